// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

// Calibration of --rig FILE (TOML, described in docs/data-formats.md). Throws SourceError with
// file, line and key; unknown keys are refused.
[[nodiscard]] Calibration read_rig_file(const std::string& file);

}  // namespace egomod
