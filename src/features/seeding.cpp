// SPDX-License-Identifier: Apache-2.0
#include "seeding.hpp"

#include <algorithm>

#include "stereo_alignment.hpp"
#include "surface_check.hpp"

namespace egomod {
namespace {

// Where corners are sought in a skewed right image: of all depths.
constexpr float kUsualDisparity_px = 30.0F;
// Corners asked for per free place: some have no partner in the right image.
constexpr float kRoomFactor = 1.3F;
// Corners tried for each free track; they come in order of rank, so that stopping keeps coverage.
constexpr std::size_t kTriesPerPlace = 2;
// So many in a row, by that share of the flow, which is known less exactly the faster the rig
// drives.
constexpr int kMovingPairs = 3;
constexpr float kMovingShare = 0.1F;
// Once half of all tracks are there no pair tries more than this share of them: where many die, as
// at driving speed, new ones are what costs most, and come over several pairs as well.
constexpr double kMaxShareTried = 0.19;

bool surely_moves(const FollowedPoint& point) {
  return point.pairs_moving >= kMovingPairs &&
         length(point.own_motion) > kMovingShare * length(point.flow);
}

}  // namespace

Seeding::Seeding(int capacity, const CornerConfig& corners, const DisparityConfig& disparity)
    : detector_(corners),
      search_(disparity),
      surroundings_(capacity),
      half_full_(static_cast<std::size_t>(capacity) / 2),
      max_tries_when_half_full_(static_cast<std::size_t>(kMaxShareTried * capacity)) {
  const auto n = 2 * static_cast<std::size_t>(capacity);
  occupied_.reserve(n);
  movers_.reserve(n);
  corners_.reserve(n);
  pixels_.reserve(n);
  right_shifts_.reserve(n);
  matches_.reserve(n);
}

void Seeding::seed(const StereoImages& images, const Skew& skew, TrackStore& store) {
  if (store.full()) return;
  occupied_.clear();
  movers_.clear();
  for (const FollowedPoint& point : store.points()) {
    if (is_left_only(point)) continue;
    occupied_.push_back(point.left);
    if (surely_moves(point)) movers_.push_back(point.left);
  }
  detector_.detect(images.left.level(0), occupied_, kRoomFactor, corners_, movers_);
  std::size_t tries = kTriesPerPlace * store.free_places();
  if (store.points().size() >= half_full_) tries = std::min(tries, max_tries_when_half_full_);
  corners_.resize(std::min(corners_.size(), tries));
  pixels_.clear();
  right_shifts_.clear();
  for (const Corner& corner : corners_) {
    pixels_.push_back(corner.position);
    const ImagePoint left{static_cast<float>(corner.position.u_px),
                          static_cast<float>(corner.position.v_px)};
    if (!skew.none()) right_shifts_.push_back(nearest_pixel(skew.shift(left, kUsualDisparity_px)));
  }
  matches_.resize(pixels_.size());
  search_.search(images.left, images.right, pixels_, matches_, right_shifts_);
  const std::size_t old = store.points().size();
  for (std::size_t i = 0; i < corners_.size() && !store.full(); ++i) {
    if (matches_[i].status != MatchStatus::kFound) continue;
    const ImagePoint left{static_cast<float>(pixels_[i].u_px), static_cast<float>(pixels_[i].v_px)};
    const StereoMeasurement start{.disparity_px = static_cast<float>(matches_[i].disparity_px)};
    const StereoMeasurement found = align_skewed(images, left, start, skew);
    if (!found.valid || !is_consistent(images, left, found)) continue;
    store.add(images.left.level(0), pixels_[i], corners_[i].kind).stereo = found;
  }
  surroundings_.sort(store);
  for (std::size_t i = old; i < store.points().size(); ++i) {
    FollowedPoint& point = store.points()[i];
    point.stereo = settle_by_neighbours(images, skew, surroundings_, point);
  }
  store.drop_if([](const FollowedPoint& point) { return point.age == 0 && !point.stereo.valid; });
}

}  // namespace egomod
