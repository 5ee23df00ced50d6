// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "table_reader.hpp"
#include "world.hpp"

namespace egomod::sim {

inline constexpr double kRadPerDeg = M_PI / 180.0;
// An angle, in degrees in the file, within the limit; 0 where it is missing.
[[nodiscard]] double degrees(TableReader& in, const std::string& key, double limit_deg);

// The tables about cameras. Throws WorldError. [camera] goes first: the others are held against it.
void read_camera(TableReader& in, World& world);
void read_realism(TableReader& in, World& world);
void read_timing(TableReader& in, World& world);
void read_calibration_error(TableReader& in, World& world);

}  // namespace egomod::sim
