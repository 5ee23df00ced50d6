// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

namespace egomod {

// Covariances rank the tracks well and are off by a common factor: learns it from chi-squares (3
// degrees of freedom) of points that stand still.
class NoiseScale {
 public:
  // Reorders `chi2`, which were whitened with covariances times `value()`.
  void learn(std::vector<double>& chi2);
  [[nodiscard]] double value() const { return value_; }
  // Median of the last ones, 1 where they fit; infinite where too few were given.
  [[nodiscard]] double misfit() const { return misfit_; }

 private:
  double value_ = 1.0;
  double misfit_ = std::numeric_limits<double>::infinity();
};

}  // namespace egomod
