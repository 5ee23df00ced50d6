// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cases.hpp"
#include "figure.hpp"
#include "threshold.hpp"

namespace egomod::thesis {

// The thesis's Figures 5 to 11, and one of the range, which it tells in words.
struct Pictures {
  eval::Plot decision;             // 5
  std::vector<eval::Plot> still;   // 6, 7, 8
  std::vector<eval::Plot> moving;  // 9, 10, 11
  eval::Plot range;

  // With names for files.
  [[nodiscard]] std::vector<std::pair<std::string, const eval::Plot*>> all() const;
};

// Throws gnuplot::GnuplotError.
[[nodiscard]] Pictures draw_pictures(const ThresholdFit& decision, const Case& still,
                                     const Case& moving, const Case& range,
                                     const eval::Evaluation& range_narrow_gate);

}  // namespace egomod::thesis
