// SPDX-License-Identifier: Apache-2.0
#include "surface_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "stereo_alignment.hpp"

namespace egomod {
namespace {

constexpr std::size_t kNearest = 6;  // are tried
constexpr std::size_t kEnough = 3;  // around a point that none of them has a surface in common with
constexpr std::uint32_t kProvenAge = 5;
constexpr float kStill_px = 0.5F;
constexpr int kBackSteps = 5;
constexpr float kSupport_px = 2.0F;
constexpr float kSlopeError = 0.05F;
constexpr float kSameDisparity_px = 3.0F;
// Of 1 - NCC, to that of the other disparity: fits clearly better.
constexpr float kClearRatio = 0.7F;

struct Neighbour {
  const FollowedPoint* point = nullptr;
  float distance2_px2 = 0.0F;
};

// The neighbour's surface, carried on to the point.
StereoMeasurement carried_on(const FollowedPoint& neighbour, ImagePoint to) {
  StereoMeasurement plane = neighbour.stereo;
  const ImagePoint off = to - neighbour.left;
  plane.disparity_px += plane.slope_u * off.u_px + plane.slope_v * off.v_px;
  return plane;
}

// The points nearest to one in an image, of those whose disparity is known, the nearest first.
class Neighbours {
 public:
  Neighbours(const PlaceGrid& grid, ImagePoint centre, const FollowedPoint& point) {
    const auto take = [&](const FollowedPoint& other, ImagePoint off) {
      const float distance2_px2 = off.u_px * off.u_px + off.v_px * off.v_px;
      if (count_ == kNearest && distance2_px2 >= nearest_.back().distance2_px2) return;
      if (other.stereo.valid && other.id != point.id) add({&other, distance2_px2});
    };
    grid.each_near(centre, take);
    // Those that are near are all there are as far as that.
    constexpr float near2_px2 = PlaceGrid::kNear_px * PlaceGrid::kNear_px;
    if (count_ == kNearest && nearest_.back().distance2_px2 <= near2_px2) return;
    count_ = 0;
    grid.each_around(centre, take);
  }
  [[nodiscard]] auto begin() const { return nearest_.begin(); }
  [[nodiscard]] auto end() const { return nearest_.begin() + static_cast<std::ptrdiff_t>(count_); }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  void add(Neighbour neighbour) {
    if (count_ < kNearest) ++count_;
    std::size_t i = count_ - 1;
    for (; i > 0 && nearest_[i - 1].distance2_px2 > neighbour.distance2_px2; --i)
      nearest_[i] = nearest_[i - 1];
    nearest_[i] = neighbour;
  }

  std::array<Neighbour, kNearest> nearest_{};
  std::size_t count_ = 0;
};

// Look-alikes would bear each other out; a wrong depth shows as motion before long.
bool is_proven(const FollowedPoint& point) {
  return point.age >= kProvenAge && length(point.own_motion) < kStill_px;
}

bool has_surface_in_common(const PlaceGrid& left, const FollowedPoint& point) {
  bool has = false;
  left.each_around(point.left, [&](const FollowedPoint& other, ImagePoint off) {
    if (!other.stereo.valid || other.id == point.id || !is_proven(other)) return;
    const float error_px = kSupport_px + kSlopeError * std::hypot(off.u_px, off.v_px);
    has = has || std::abs(carried_on(other, point.left).disparity_px - point.stereo.disparity_px) <
                     error_px;
  });
  return has;
}

// What is nearest to the point lies outside of the right image there.
bool lies_outside(const Neighbours& neighbours, const FollowedPoint& point) {
  const auto outside =
      std::count_if(neighbours.begin(), neighbours.end(), [&](const Neighbour& neighbour) {
        return carried_on(*neighbour.point, point.left).disparity_px >
               point.left.u_px - static_cast<float>(kPatchRadiusU_px);
      });
  return neighbours.count() >= kEnough &&
         2 * static_cast<std::size_t>(outside) > neighbours.count();
}

// Left of something nearer in the left image and right of it in the right one: possible beside a
// pole, but mostly a look-alike.
bool is_seen_past(const Neighbours& neighbours, const FollowedPoint& point) {
  const float right_px = right_of(point.left, point.stereo).u_px;
  return std::any_of(neighbours.begin(), neighbours.end(), [&](const Neighbour& neighbour) {
    const FollowedPoint& other = *neighbour.point;
    return is_proven(other) && other.left.u_px > point.left.u_px &&
           right_of(other.left, other.stereo).u_px < right_px - kSameDisparity_px;
  });
}

bool same(const StereoMeasurement& a, const StereoMeasurement& b) {
  return std::abs(a.disparity_px - b.disparity_px) <= kSameDisparity_px;
}

bool fits_clearly_better(float ncc, float other_ncc) {
  return 1.0F - ncc <= kClearRatio * (1.0F - other_ncc);
}

// How far along the row from the point the surface shows in the left image what the right image
// shows at the point's match.
float offset_px(const StereoMeasurement& surface, const StereoMeasurement& own) {
  return (surface.disparity_px - own.disparity_px) / (1.0F - surface.slope_u);
}

// The surfaces of the nearest neighbours that give the point other disparities.
class Surfaces {
 public:
  void add(const StereoMeasurement& surface) {
    const auto known = [&](const StereoMeasurement& s) { return same(s, surface); };
    if (std::none_of(all().begin(), all().end(), known)) surfaces_[count_++] = surface;
  }
  [[nodiscard]] std::span<const StereoMeasurement> all() const {
    return std::span(surfaces_).first(count_);
  }

 private:
  std::array<StereoMeasurement, kNearest> surfaces_{};
  std::size_t count_ = 0;
};

Surfaces rivals_of(const Neighbours& neighbours, const FollowedPoint& point) {
  Surfaces rivals;
  for (const Neighbour& neighbour : neighbours) {
    const StereoMeasurement surface = carried_on(*neighbour.point, point.left);
    if (!same(surface, point.stereo)) rivals.add(surface);
  }
  return rivals;
}

}  // namespace

bool belongs_to_another(const StereoImages& images, const Surroundings& surroundings,
                        const FollowedPoint& point) {
  const ImagePoint right = right_of(point.left, point.stereo);
  const Surfaces surfaces = rivals_of(Neighbours(surroundings.right, right, point), point);
  const auto ncc_back = [&](const StereoMeasurement& on, float off_px) {
    return align_back(images, point.left, point.stereo, on, off_px, kBackSteps).ncc;
  };
  if (surfaces.all().empty()) return false;
  const float own = ncc_back(point.stereo, 0.0F);
  return std::any_of(surfaces.all().begin(), surfaces.all().end(), [&](const auto& surface) {
    return fits_clearly_better(ncc_back(surface, offset_px(surface, point.stereo)), own);
  });
}

StereoMeasurement settle_by_neighbours(const StereoImages& images, const Skew& skew,
                                       const Surroundings& surroundings,
                                       const FollowedPoint& point) {
  const StereoMeasurement& own = point.stereo;
  const Neighbours neighbours(surroundings.left, point.left, point);
  const Surfaces rivals = rivals_of(neighbours, point);
  StereoMeasurement other;  // the best one that differs
  for (const StereoMeasurement& start : rivals.all()) {
    const StereoMeasurement found = align_skewed(images, point.left, start, skew);
    if (found.valid && !same(found, own) && found.ncc > other.ncc &&
        is_consistent(images, point.left, found))
      other = found;
  }
  if (other.valid && fits_clearly_better(other.ncc, own.ncc)) return other;
  const bool must_be_borne_out = lies_outside(neighbours, point) || is_seen_past(neighbours, point);
  const bool stays = (!other.valid || fits_clearly_better(own.ncc, other.ncc)) &&
                     (!must_be_borne_out || has_surface_in_common(surroundings.left, point)) &&
                     !belongs_to_another(images, surroundings, point);
  return stays ? own : StereoMeasurement{};
}

}  // namespace egomod
