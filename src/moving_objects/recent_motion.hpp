// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "moving_objects/body_motion.hpp"
#include "moving_objects/group_shape.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// How a body moved over its last few pairs, against a velocity that filters have learnt: that one
// is more precise, but may be behind.
struct RecentMotion {
  Eigen::Vector3d ahead_mps = Eigen::Vector3d::Zero();  // of that velocity
  Eigen::Matrix3d covariance_m2ps2 = Eigen::Matrix3d::Zero();
  double proven = 0.0;  // 0..1, that the velocity is behind: noise alone does not explain it
};

// Mean over the points' velocities, turned back by the body's rotation about `at_m`, in the window
// that is most precise of those that agree with all shorter ones (A. Goldenshluger, A. Nemirovski,
// 1997): a longer one has less noise, but may reach back beyond a change. `acceleration_m2ps4` is
// what the body may well do meanwhile. Nothing where too few points were seen.
[[nodiscard]] RecentMotion fit_recent_motion(std::span<const PointSample> points, Members members,
                                             const BodyMotion& body, const Eigen::Vector3d& at_m,
                                             const Eigen::Vector3d& velocity_mps,
                                             const Eigen::Matrix3d& acceleration_m2ps4);

// Moves the velocity as far ahead as is proven, or to be expected (`start_m2ps2`). Its covariance
// for manoeuvres becomes what they may be now that the last few pairs are known.
void take(const RecentMotion& recent, const Eigen::Matrix3d& start_m2ps2,
          Eigen::Vector3d& velocity_mps, Eigen::Matrix3d& manoeuvres_m2ps2);

}  // namespace egomod
