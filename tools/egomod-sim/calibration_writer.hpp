// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "egomod/core/calibration.hpp"

namespace egomod::sim {

// calib_full.txt of raw images; numbers as exact as they are here. Throws std::ios::failure.
void write_raw_calibration(const Calibration& calibration, const std::filesystem::path& file);

}  // namespace egomod::sim
