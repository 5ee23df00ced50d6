// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "evaluation.hpp"
#include "figure.hpp"

namespace egomod::eval {

// What there is data for. Throws gnuplot::GnuplotError.
[[nodiscard]] std::vector<Plot> draw_plots(const Evaluation& evaluation);

}  // namespace egomod::eval
