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
  // Forgets the guess and, where `moving_on` is not set, the motion that the next one starts from.
  void begin_pair(const StereoCamera& camera, bool moving_on);

  // From the points that are followed and had a disparity; false where they agree on no motion.
  bool guess(const TrackStore& store);

  // Where the point is now if it rests; nothing without a guess or a disparity.
  [[nodiscard]] std::optional<ImagePoint> predict(const FollowedPoint& point) const;

 private:
  struct Sample {
    Eigen::Vector3d P_m;
    Eigen::Vector2d seen;  // normalised image coordinates
  };

  void gather(const TrackStore& store);
  void refine(double scale, Eigen::Isometry3d& T_current_previous) const;
  [[nodiscard]] double share_near(const Eigen::Isometry3d& T_current_previous) const;

  StereoCamera camera_;
  Eigen::Isometry3d T_current_previous_ = Eigen::Isometry3d::Identity();
  bool known_ = false;
  std::vector<Sample> samples_;
};

}  // namespace egomod
