// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/geometry.hpp"

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

  // Of a point at this offset from the camera, both in the first camera's axes: T * Exp(xi) moves
  // it by R (rho + phi x P) = rho' - [offset]x phi'.
  [[nodiscard]] Eigen::Matrix3d covariance_at(const Eigen::Vector3d& offset_m) const {
    const Eigen::Matrix3d S = skew(offset_m);
    const Eigen::Matrix3d CS = cross_covariance * S;
    const Eigen::Matrix3d DS = rotation_covariance * S;
    Eigen::Matrix3d C = translation_covariance + CS + CS.transpose();
    C.noalias() -= S * DS;
    return C;
  }

  Eigen::Isometry3d T_first_current = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_current_first = Eigen::Isometry3d::Identity();
  // Of the motion since the previous pair, in the first camera's axes.
  Eigen::Matrix3d translation_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d cross_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();
};

}  // namespace egomod
