// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace egomod {

// From here on a displacement between two pairs shows motion by itself, and movers leave the reach
// of a usual search.
inline constexpr double kLongInterval_s = 0.15;

// Whether pairs come slowly, by the interval before this one and the one before that (0: there was
// none). A long interval after a short one is a hole, and its pair is like any other.
[[nodiscard]] constexpr bool is_low_rate(double interval_s, double previous_interval_s) {
  return interval_s > kLongInterval_s &&
         (previous_interval_s == 0.0 || previous_interval_s > kLongInterval_s);
}

}  // namespace egomod
