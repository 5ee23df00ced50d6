// SPDX-License-Identifier: Apache-2.0
#include "surface_check.hpp"

#include <array>
#include <cmath>

#include "stereo_alignment.hpp"

namespace egomod {
namespace {

constexpr float kReach_px = 80.0F;
constexpr std::size_t kNeighbours = 6;
constexpr float kSameDisparity_px = 3.0F;
// Of 1 - NCC, to that of the other disparity: fits clearly better.
constexpr float kClearRatio = 0.7F;

// The nearest points whose disparity is known, the nearest first.
class Neighbours {
 public:
  Neighbours(const TrackStore& store, const FollowedPoint& point) {
    for (const FollowedPoint& other : store.points()) {
      const ImagePoint off = other.left - point.left;
      if (std::abs(off.u_px) > kReach_px || std::abs(off.v_px) > kReach_px || !other.stereo.valid ||
          other.id == point.id)
        continue;
      add({&other, off.u_px * off.u_px + off.v_px * off.v_px});
    }
  }
  struct Entry {
    const FollowedPoint* point = nullptr;
    float distance2_px2 = 0.0F;
  };
  [[nodiscard]] auto begin() const { return entries_.begin(); }
  [[nodiscard]] auto end() const { return entries_.begin() + static_cast<std::ptrdiff_t>(count_); }

 private:
  void add(Entry entry) {
    if (count_ == kNeighbours && entry.distance2_px2 >= entries_.back().distance2_px2) return;
    if (count_ < kNeighbours) ++count_;
    std::size_t i = count_ - 1;
    for (; i > 0 && entries_[i - 1].distance2_px2 > entry.distance2_px2; --i)
      entries_[i] = entries_[i - 1];
    entries_[i] = entry;
  }

  std::array<Entry, kNeighbours> entries_{};
  std::size_t count_ = 0;
};

bool same(const StereoMeasurement& a, const StereoMeasurement& b) {
  return std::abs(a.disparity_px - b.disparity_px) <= kSameDisparity_px;
}

bool fits_clearly_better(const StereoMeasurement& a, const StereoMeasurement& b) {
  return 1.0F - a.ncc <= kClearRatio * (1.0F - b.ncc);
}

// The neighbour's surface, carried on to the point.
StereoMeasurement carried_on(const FollowedPoint& neighbour, ImagePoint to) {
  StereoMeasurement plane = neighbour.stereo;
  const ImagePoint off = to - neighbour.left;
  plane.disparity_px += plane.slope_u * off.u_px + plane.slope_v * off.v_px;
  return plane;
}

}  // namespace

StereoMeasurement settle_by_neighbours(const StereoImages& images, const Skew& skew,
                                       const TrackStore& store, const FollowedPoint& point) {
  StereoMeasurement best = point.stereo;
  StereoMeasurement other;  // the best one that differs
  std::array<StereoMeasurement, kNeighbours> tried;
  std::size_t tries = 0;
  for (const Neighbours::Entry& neighbour : Neighbours(store, point)) {
    const StereoMeasurement start = carried_on(*neighbour.point, point.left);
    if (same(start, point.stereo)) continue;
    bool known = false;
    for (std::size_t i = 0; i < tries; ++i) known = known || same(start, tried[i]);
    if (known) continue;
    tried[tries++] = start;
    const StereoMeasurement found = align_skewed(images, point.left, start, skew);
    if (!found.valid || same(found, point.stereo) || found.ncc <= other.ncc ||
        !is_consistent(images, point.left, found))
      continue;
    other = found;
  }
  if (!other.valid || fits_clearly_better(best, other)) return best;
  if (!fits_clearly_better(other, best)) other.valid = false;
  return other;
}

}  // namespace egomod
