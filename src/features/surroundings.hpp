// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "track_store.hpp"

namespace egomod {

// Finds the points around one without looking at all of them: they are sorted into cells as wide as
// the reach. Nothing is allocated after construction.
class Surroundings {
 public:
  static constexpr float kReach_px = 80.0F;

  explicit Surroundings(int capacity) {
    cells_.reserve(static_cast<std::size_t>(capacity));
    places_.reserve(static_cast<std::size_t>(capacity));
  }

  // Holds until points are added, dropped or moved.
  void sort(const TrackStore& store);

  // Calls `visit(other, off)` for all points within the reach along each axis, that at `centre`
  // too. `off` is how far from there.
  template <typename Visit>
  void each_around(ImagePoint centre, Visit visit) const {
    const int column = cell_along(centre.u_px), row = cell_along(centre.v_px);
    const int first = std::max(column - 1, 0), last = std::min(column + 1, kCells - 1);
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, kCells - 1); ++r) {
      for (auto i = starts_[cell(first, r)]; i < starts_[cell(last, r) + 1]; ++i) {
        const ImagePoint off = places_[i].left - centre;
        if (std::abs(off.u_px) <= kReach_px && std::abs(off.v_px) <= kReach_px)
          visit((*points_)[places_[i].point], off);
      }
    }
  }

 private:
  struct Place {
    ImagePoint left;
    std::uint32_t point;
  };

  static constexpr int kCells = 64;  // along each axis; what lies further is in the last one

  [[nodiscard]] static int cell_along(float x_px) {
    return std::clamp(static_cast<int>(x_px / kReach_px), 0, kCells - 1);
  }
  [[nodiscard]] static std::size_t cell(int column, int row) {
    return static_cast<std::size_t>(row * kCells + column);
  }

  const std::vector<FollowedPoint>* points_ = nullptr;
  std::vector<Place> places_;         // cell by cell
  std::vector<std::uint32_t> cells_;  // of each point
  std::array<std::uint32_t, kCells * kCells + 1> starts_{};
};

}  // namespace egomod
