// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/core/stereo_pair.hpp"

namespace egomod::bench {

// CPU time of this thread.
[[nodiscard]] double cpu_seconds();

// The yardstick Y: CPU time that OpenCV's ORB (1000 features, one thread) needs to detect and
// describe on both images of a pair; the median of several runs in this process.
[[nodiscard]] double measure_yardstick_s(const StereoPair& pair);

}  // namespace egomod::bench
