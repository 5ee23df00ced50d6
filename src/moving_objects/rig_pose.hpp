// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "moving_objects/filter_kernels.hpp"

namespace egomod {

// The camera of one pair in the first one's frame, and what its error does to points.
struct RigPose {
  RigPose() = default;
  explicit RigPose(const Egomotion& motion)
      : T_first_current(motion.T_first_current), T_current_first(motion.T_first_current.inverse()) {
    const Eigen::Matrix3d R = T_first_current.linear();
    const Matrix6d& C = motion.covariance_previous_current;
    translation_covariance = R * C.topLeftCorner<3, 3>() * R.transpose();
    cross_covariance = R * C.topRightCorner<3, 3>() * R.transpose();
    rotation_covariance = R * C.bottomRightCorner<3, 3>() * R.transpose();
  }

  Eigen::Isometry3d T_first_current = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_current_first = Eigen::Isometry3d::Identity();
  // Of the motion since the previous pair, in the first camera's axes.
  Eigen::Matrix3d translation_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d cross_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();
};

// The rig's share of what the kernels are told; noise, prior and time are the caller's.
[[nodiscard]] FilterStep filter_step(const RigPose& rig, const StereoCamera& camera);

}  // namespace egomod
