// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sequence.hpp"

namespace egomod::eval {

// The truth that a record of the built-in world holds, on SIM_TRUTH_POSE and SIM_TRUTH_OBJECTS.
// Frames that were not recorded get a time between their neighbours', and nothing else. Throws an
// exception that names file and place.
[[nodiscard]] Truth read_truth_of_record(const std::string& log);

}  // namespace egomod::eval
