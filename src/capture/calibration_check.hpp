// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

// What is wrong with a calibration, sizes included; empty if nothing is.
[[nodiscard]] std::string fault_of(const Calibration& calibration);

}  // namespace egomod
