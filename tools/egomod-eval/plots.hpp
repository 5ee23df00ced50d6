// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "evaluation.hpp"

namespace egomod::eval {

struct Plot {
  std::string caption;
  std::string svg;  // one <svg> element
};

// What there is data for. Throws gnuplot::GnuplotError.
[[nodiscard]] std::vector<Plot> draw_plots(const Evaluation& evaluation);

}  // namespace egomod::eval
