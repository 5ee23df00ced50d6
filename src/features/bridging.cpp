// SPDX-License-Identifier: Apache-2.0
#include "bridging.hpp"

namespace egomod {

Bridging::Bridging(int capacity, const CornerConfig& corners, double search_radius_share)
    : detector_(corners), matcher_({}), radius_share_(static_cast<float>(search_radius_share)) {
  const auto n = 2 * static_cast<std::size_t>(capacity);
  corners_.reserve(n);
  lost_.reserve(n);
  olds_.reserve(n);
  candidates_.reserve(n);
  matches_.reserve(n);
}

void Bridging::describe_lost(const Pyramid& previous, const TrackStore& store) {
  lost_.clear();
  olds_.clear();
  for (std::size_t i = 0; i < store.points().size(); ++i) {
    const FollowedPoint& point = store.points()[i];
    if (point.followed) continue;
    DescribedPoint old{.position = point.previous_left, .kind = point.kind, .descriptor = {}};
    if (!describe(previous, old.position, old.descriptor)) continue;
    lost_.push_back(i);
    olds_.push_back(old);
  }
}

void Bridging::describe_corners(const Pyramid& current) {
  detector_.detect(current.level(0), {}, 1.5F, corners_);
  candidates_.clear();
  for (const Corner& corner : corners_) {
    DescribedPoint candidate{.position = {static_cast<float>(corner.position.u_px),
                                          static_cast<float>(corner.position.v_px)},
                             .kind = corner.kind,
                             .descriptor = {}};
    if (describe(current, candidate.position, candidate.descriptor)) {
      candidates_.push_back(candidate);
    }
  }
}

void Bridging::find_lost(const StereoImages& previous, const StereoImages& current,
                         TemporalAlignment& alignment, TrackStore& store) {
  describe_lost(previous.left, store);
  describe_corners(current.left);
  matches_.resize(olds_.size());
  const float radius_px = radius_share_ * static_cast<float>(current.left.level(0).width_px);
  matcher_.match(olds_, candidates_, radius_px, matches_);
  for (std::size_t k = 0; k < lost_.size(); ++k) {
    if (matches_[k].candidate < 0) continue;
    const DescribedPoint& found = candidates_[static_cast<std::size_t>(matches_[k].candidate)];
    alignment.follow_to(current, store, found.position, store.points()[lost_[k]]);
  }
}

}  // namespace egomod
