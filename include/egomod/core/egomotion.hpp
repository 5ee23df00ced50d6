// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "egomod/core/time.hpp"

namespace egomod {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

enum class EstimateStatus : std::uint8_t {
  kValid,
  kFirst,      // the first pair, or the first after a reset: identity motion by definition
  kSkipped,    // the pair was dropped by capture.max_rate_hz: the last pose again
  kFailed,     // no motion could be estimated: the last pose again
  kAmbiguous,  // geometry cannot tell who moves: the motion that the prior favours
};

enum class EstimateReason : std::uint8_t {
  kNone,
  kFewTracks,   // too little texture or too few matches
  kFewInliers,  // no motion explains enough tracks
  kDegenerate,  // the tracks do not constrain all six degrees of freedom
  kNotConverged,
  kPairRejected,  // capture rejected the pair
  kHole,          // pairs were missing; tracks bridge the hole, the motion in it is composed
  kReseeded,      // no track bridges the hole: no motion assumed, covariance inflated
  kMoverDominates,
  kRecalibrated,      // the calibration changed: no motion assumed, covariance inflated
  kWheelsContradict,  // all that is seen moves as one, but not as the wheels do
};

enum class TrackRole : std::uint8_t {
  kUnused,   // no observation in both pairs
  kInlier,   // explained by the rig's motion
  kOutlier,  // not explained: mover or mismatch
};

// When a rolling shutter exposes its rows: a pair's time is the middle row's.
struct RowTiming {
  double readout_s = 0.0;                // from the first row to the last
  Vector6d velocity = Vector6d::Zero();  // of the rig at the middle row: m/s and rad/s, its axes
};

// How the rig moved between the previous and the current pair. All frames are left camera frames.
// Covariances: order translation (m), rotation (rad); right perturbation T = T_estimate * Exp(xi).
struct Egomotion {
  std::uint64_t sequence = 0;
  Nanoseconds exposure{0};
  Nanoseconds previous_exposure{0};
  EstimateStatus status = EstimateStatus::kFirst;
  EstimateReason reason = EstimateReason::kNone;
  int quality = 0;  // 0..100
  int inliers = 0;
  std::uint32_t reset_count = 0;
  double residual_px = 0.0;  // robust scale of the inliers' reprojection error
  RowTiming rows;

  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  Matrix6d covariance_previous_current = Matrix6d::Zero();
  // First left camera frame from the current one, accumulated; covariance since the last reset.
  Eigen::Isometry3d T_first_current = Eigen::Isometry3d::Identity();
  Matrix6d covariance_first_current = Matrix6d::Zero();

  std::vector<TrackRole> roles;  // parallel to TrackSet::tracks
};

}  // namespace egomod
