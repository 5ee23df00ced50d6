// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace egomod::eval {

struct Summary {
  std::size_t count = 0;
  double median = 0.0, mean = 0.0, rmse = 0.0, p90 = 0.0, p99 = 0.0, max = 0.0;
};

// Of the finite values; nothing when there is none. Quantiles interpolate linearly.
[[nodiscard]] std::optional<Summary> summarise(std::vector<double> values);

// Normalised estimation error squared of n errors with `dof` degrees of freedom each: consistent
// covariances give a mean over dof of about 1.
struct Consistency {
  std::size_t count = 0;
  int dof = 0;
  double mean_per_dof = 0.0, median_per_dof = 0.0;
  double within_95 = 0.0;  // share inside the 95 % ellipsoid
};

[[nodiscard]] std::optional<Consistency> consistency(const std::vector<double>& nees, int dof);

}  // namespace egomod::eval
