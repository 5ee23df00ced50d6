// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "evaluation.hpp"

namespace egomod::eval {

// All figures: one object for a single run, else an array of them. What there is none of is null.
[[nodiscard]] std::string json_of(const std::vector<Evaluation>& evaluations);

}  // namespace egomod::eval
