// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "moving_objects/group_shape.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

inline constexpr double kUsualLag_s = 0.15;  // of filters nearby, and where nothing tells

// How a rigid body moves, relative to the static world, in the axes of its points.
struct BodyMotion {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // of the body where it is at `at_m`
  Eigen::Matrix3d velocity_covariance_m2ps2 =
      Eigen::Matrix3d::Zero();  // while it goes on as it does
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  // By what time the velocity is behind where it changes steadily, symmetric. A filter that follows
  // a constant velocity with acceleration noise of density q, and has come to rest at the variance
  // P of its velocity, is P/q behind (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with
  // Applications to Tracking and Navigation, 2001, section 6.5, in the limit of small intervals).
  Eigen::Matrix3d lag_s = kUsualLag_s * Eigen::Matrix3d::Identity();
};

// Least squares over the points' velocities, v_i = v + w x (P_i - at), each weighted by its inverse
// covariance; errors of two points correlate by `correlation`. Six degrees of freedom where the
// points show beyond doubt that the body turns, otherwise three: the mean velocity, w = 0.
[[nodiscard]] BodyMotion fit_body_motion(std::span<const PointSample> points, Members members,
                                         const Eigen::Vector3d& at_m, double correlation);

}  // namespace egomod
