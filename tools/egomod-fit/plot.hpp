// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/moving_objects/rayleigh.hpp"
#include "labels.hpp"

namespace egomod::fit {

// Draws the thesis's Figure 5 with gnuplot: above both likelihoods over the samples' histograms,
// below the posteriors with the 50 % and 99 % thresholds. Leaves `DIR/rayleigh.gp` to redraw it.
// `format` is png or svg. Returns the picture's path; throws InputError or GnuplotError when
// it cannot be drawn.
std::string draw_figure(const std::string& directory, const std::string& format,
                        const Labels& labels, const RayleighFit& fit);

}  // namespace egomod::fit
