// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "track_store.hpp"

namespace egomod {

// Finds points by their place in one image without looking at all of them: they are sorted into
// cells half as wide as the reach. Nothing is allocated after construction.
class PlaceGrid {
 public:
  static constexpr float kReach_px = 80.0F;
  static constexpr float kNear_px = 0.5F * kReach_px;

  explicit PlaceGrid(int capacity) {
    cells_.reserve(static_cast<std::size_t>(capacity));
    places_.reserve(static_cast<std::size_t>(capacity));
  }

  // Holds until points are added, dropped or moved.
  template <typename Where>
  void sort(const std::vector<FollowedPoint>& points, Where where) {
    points_ = &points;
    cells_.clear();
    starts_.fill(0);
    for (const FollowedPoint& point : points) {
      const ImagePoint at = where(point);
      cells_.push_back(static_cast<std::uint32_t>(cell(cell_along(at.u_px), cell_along(at.v_px))));
      ++starts_[cells_.back() + 1];
    }
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    places_.resize(cells_.size());
    // From the last on, each takes the last free place of its cell.
    std::array<std::uint32_t, kCells * kCells> ends;
    std::copy(starts_.begin() + 1, starts_.end(), ends.begin());
    for (std::size_t i = cells_.size(); i > 0; --i)
      places_[--ends[cells_[i - 1]]] = {where(points[i - 1]), static_cast<std::uint32_t>(i - 1)};
  }

  // Calls `visit(other, off)` for all points within the reach along each axis, that at `centre`
  // too. `off` is how far from there.
  template <typename Visit>
  void each_around(ImagePoint centre, Visit visit) const {
    each_within(kReach_px, 2, centre, visit);
  }
  // For those within kNear_px along each axis.
  template <typename Visit>
  void each_near(ImagePoint centre, Visit visit) const {
    each_within(kNear_px, 1, centre, visit);
  }

 private:
  struct Place {
    ImagePoint at;
    std::uint32_t point;
  };

  static constexpr int kCells = 64;  // along each axis; what lies further is in the last one

  template <typename Visit>
  void each_within(float reach_px, int cells, ImagePoint centre, Visit visit) const {
    const int column = cell_along(centre.u_px), row = cell_along(centre.v_px);
    const int first = std::max(column - cells, 0), last = std::min(column + cells, kCells - 1);
    for (int r = std::max(row - cells, 0); r <= std::min(row + cells, kCells - 1); ++r) {
      for (auto i = starts_[cell(first, r)]; i < starts_[cell(last, r) + 1]; ++i) {
        const ImagePoint off = places_[i].at - centre;
        if (std::abs(off.u_px) <= reach_px && std::abs(off.v_px) <= reach_px)
          visit((*points_)[places_[i].point], off);
      }
    }
  }

  [[nodiscard]] static int cell_along(float x_px) {
    return std::clamp(static_cast<int>(x_px / kNear_px), 0, kCells - 1);
  }
  [[nodiscard]] static std::size_t cell(int column, int row) {
    return static_cast<std::size_t>(row * kCells + column);
  }

  const std::vector<FollowedPoint>* points_ = nullptr;
  std::vector<Place> places_;         // cell by cell
  std::vector<std::uint32_t> cells_;  // of each point
  std::array<std::uint32_t, kCells * kCells + 1> starts_{};
};

// Where both images show the points, as far as their disparities are known.
struct Surroundings {
  explicit Surroundings(int capacity) : left(capacity), right(capacity) {}

  void sort(const TrackStore& store) {
    left.sort(store.points(), [](const FollowedPoint& point) { return point.left; });
    right.sort(store.points(),
               [](const FollowedPoint& point) { return right_of(point.left, point.stereo); });
  }

  PlaceGrid left, right;
};

}  // namespace egomod
