// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "labels.hpp"

namespace egomod::fit {

// Labels the point velocities of a record (EGOMOD_TRACKS) by the truth's objects.csv in
// `truth_directory`: inside a moving object's visible rectangle and depth is moving, outside every
// rectangle is static, the rest is left out.
[[nodiscard]] Labels label_record(const std::string& log, const std::string& truth_directory);

}  // namespace egomod::fit
