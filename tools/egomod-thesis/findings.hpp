// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "cases.hpp"
#include "figure_tables.hpp"
#include "threshold.hpp"

namespace egomod::thesis {

struct Cases {
  Case still, moving, range;
  // To find out what limits the range: the preset with a gate of RANSAC of 1 px instead of 2 on
  // `range`; on targets that come near; there with a search for greater disparities.
  eval::Evaluation range_narrow_gate;
  std::vector<eval::Evaluation> near, near_wide_search;
};

// What the thesis says beside what came out here.
[[nodiscard]] eval::FigureTable comparison_table(const Cases& cases,
                                                 const std::vector<ThresholdFit>& fits);
// What the threshold depends on.
[[nodiscard]] eval::FigureTable threshold_table(const std::vector<ThresholdFit>& fits);
// Errors of both methods in both cases, before and after the depth where the thesis saw them grow.
[[nodiscard]] eval::FigureTable error_table(const Cases& cases);

// Why they differ.
struct Deviation {
  std::string what;
  std::string why;
};
[[nodiscard]] std::vector<Deviation> deviations(const Cases& cases,
                                                const std::vector<ThresholdFit>& fits);

// Median time of a pair through all stages; nothing where the record has no timing.
[[nodiscard]] std::optional<double> pair_ms(const eval::Evaluation& evaluation);

}  // namespace egomod::thesis
