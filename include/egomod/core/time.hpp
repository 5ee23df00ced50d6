// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

namespace egomod {

// The one time type inside. Live: host monotonic clock. Replay: exactly 1000 * utime of the data.
using Nanoseconds = std::chrono::nanoseconds;

[[nodiscard]] constexpr double to_seconds(Nanoseconds t) {
  return std::chrono::duration<double>(t).count();
}

[[nodiscard]] constexpr double to_milliseconds(Nanoseconds t) { return 1e3 * to_seconds(t); }

}  // namespace egomod
