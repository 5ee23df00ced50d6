// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "egomod/core/egomotion.hpp"

namespace egomod {

// Quantiles of the chi-square distribution.
inline constexpr double kMedianChi2Of2 = 1.386;
inline constexpr double kMedianChi2Of3 = 2.366;
inline constexpr double kChi2Of3At99Percent = 11.34;

// Reorders `values`; `if_empty` when there are none.
[[nodiscard]] double median(std::vector<double>& values, double if_empty);
[[nodiscard]] double largest_sigma(const Eigen::Matrix3d& covariance);
[[nodiscard]] Matrix6d diagonal_covariance(double translation_sigma_m, double rotation_sigma_rad);

}  // namespace egomod
