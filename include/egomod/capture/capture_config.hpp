// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod {

struct CaptureConfig {
  double max_rate_hz = 0.0;  // 0: every pair
  double max_skew_s = 0.0;   // 0: half a frame interval
  // Between two readings of the wheels' odometry that are joined, or after the last one.
  double wheels_max_age_s = 0.2;
  std::string left_channel{};  // bot_core.image_t channels of `log` and `lcm`; empty: EGOMOD_IMAGES
  std::string right_channel{};
};

}  // namespace egomod
