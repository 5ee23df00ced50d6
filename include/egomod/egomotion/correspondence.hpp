// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod {

// Nearer points, and those behind the camera, are not projected.
inline constexpr double kMinDepthM = 0.05;

// A scene point known from the past, and where the current pair sees it. "Previous" is the left
// camera frame that the motion is measured from.
struct Correspondence {
  Eigen::Vector3d P_previous_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_previous_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d observed_px = Eigen::Vector3d::Zero();  // u, v, disparity in the current pair
  Eigen::Matrix3d covariance_observed_px2 = Eigen::Matrix3d::Zero();
  double static_weight = 1.0;  // 0..1, belief from earlier pairs that the point stands still
  std::size_t track = 0;       // index in TrackSet::tracks
};

// Whether an observation is finite and its disparity stands out from its noise: one that does not
// lends its point a depth made of noise, and with it a translation.
[[nodiscard]] bool usable(const StereoObservation& observation);

// The correspondence of a track that both pairs observed; false when a disparity is not usable.
[[nodiscard]] bool correspondence_of(const StereoCamera& camera, const Eigen::Vector3d& previous_px,
                                     const Eigen::Matrix3d& covariance_previous_px2,
                                     Correspondence& result);

// Squared Euclidean distance (px^2) between the observation and the transferred point, summed over
// the left and the right image; infinite when the point lies behind the camera.
[[nodiscard]] double squared_reprojection_error(const StereoCamera& camera,
                                                const Eigen::Isometry3d& T_current_previous,
                                                const Correspondence& c);

}  // namespace egomod
