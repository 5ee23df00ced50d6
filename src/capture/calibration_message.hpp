// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "egomod/core/calibration.hpp"
#include "egomod/core/time.hpp"

namespace egomod {

struct TimedCalibration {
  Nanoseconds holds_from{0};
  Calibration calibration;
};

// An encoded egomod.calibration_t; nothing if it is not one. Its values are not checked.
[[nodiscard]] std::optional<TimedCalibration> decode_calibration(
    std::span<const std::uint8_t> message);

}  // namespace egomod
