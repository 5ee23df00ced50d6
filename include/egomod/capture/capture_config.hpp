// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod {

struct CaptureConfig {
  double max_rate_hz = 0.0;    // 0: every pair
  double max_skew_s = 0.0;     // 0: half a frame interval
  std::string left_channel{};  // bot_core.image_t channels of `log` and `lcm`; empty: EGOMOD_IMAGES
  std::string right_channel{};
};

}  // namespace egomod
