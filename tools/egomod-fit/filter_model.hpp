// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "egomod/moving_objects/moving_objects_config.hpp"
#include "filter_samples.hpp"
#include "options.hpp"

namespace egomod::fit {

// A cut that is in force, and the one that the samples ask for, where they ask for any.
struct FittedCut {
  double present = 0.0;
  std::optional<double> best;
};

struct FilterModel {
  FittedCut evidence, chi2;                  // of points; both cuts are built in
  FittedCut min_evidence, confirm_evidence;  // of objects
  std::optional<double> velocity_prior_mps;
};

// `samples` are sorted. `prior_moving` is of points; without one it is their share in the samples.
[[nodiscard]] FilterModel fit_model(const FilterSamples& samples, const MovingObjectsConfig& config,
                                    std::optional<double> prior_moving);

// Labels the records, fits, prints and draws. Throws an exception that says why that fails.
[[nodiscard]] FitResult fit_filter(const Options& options);

}  // namespace egomod::fit
