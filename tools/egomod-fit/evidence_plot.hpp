// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "filter_model.hpp"

namespace egomod::fit {

// Draws with gnuplot how points and objects of both classes are spread over what the method filter
// decides by, with the cuts in force and the fitted ones. Leaves `DIR/evidence.gp` to redraw it.
// `format` is png or svg. Returns the picture's path; throws InputError or GnuplotError.
[[nodiscard]] std::string draw_evidence(const std::string& directory, const std::string& format,
                                        const FilterSamples& samples, const FilterModel& model);

}  // namespace egomod::fit
