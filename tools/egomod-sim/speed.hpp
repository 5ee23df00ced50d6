// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "simulator.hpp"

namespace egomod::sim {

// How fast the world's pairs come, and their truth, when nothing is written: time by the clock, and
// of all processors together. For people to read.
[[nodiscard]] std::string measure_speed(Simulator& simulator);

}  // namespace egomod::sim
