// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "egomod/core/egomotion.hpp"

namespace egomod {

// What a solver makes of a set of correspondences.
struct Solution {
  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  // right perturbation
  EstimateReason failure = EstimateReason::kNone;
};

}  // namespace egomod
