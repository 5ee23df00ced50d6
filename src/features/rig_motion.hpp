// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "track_store.hpp"

namespace egomod {

// A guess of how the rig moved since the previous pair, from the points found so far: good enough
// to predict where resting points are seen. Which points do rest is for later stages to say; a
// point that moves is found elsewhere. Threads: one caller.
class RigMotion {
 public:
  // The last motion goes on, for `interval_ratio` times as long as the last pair took; without
  // `moving_on`, nothing is known of it.
  void begin_pair(const StereoCamera& camera, bool moving_on, float interval_ratio);

  // From the points that are followed and had a disparity; false where they agree on no motion.
  bool guess(const TrackStore& store);

  [[nodiscard]] std::optional<Eigen::Isometry3d> T_current_previous() const {
    return known_ ? std::optional(T_current_previous_) : std::nullopt;
  }

  // A resting point now: where it is seen, and its disparity.
  struct Resting {
    ImagePoint left;
    float disparity_px = 0.0F;
  };
  // Nothing where the motion is unknown, or the point's depth.
  [[nodiscard]] std::optional<Resting> predict(const FollowedPoint& point) const;

 private:
  struct Sample {
    Eigen::Vector3d P_m;
    Eigen::Vector2d seen;  // normalised image coordinates
  };

  void gather(const TrackStore& store);
  void refine(double scale, Eigen::Isometry3d& T_current_previous) const;
  [[nodiscard]] double share_near(const Eigen::Isometry3d& T_current_previous) const;
  [[nodiscard]] bool rests(const Eigen::Isometry3d& T_current_previous) const;

  StereoCamera camera_;
  Eigen::Isometry3d T_current_previous_ = Eigen::Isometry3d::Identity();
  bool known_ = false;
  std::vector<Sample> samples_;
};

}  // namespace egomod
