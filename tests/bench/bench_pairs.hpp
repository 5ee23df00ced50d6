// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "egomod/core/stereo_pair.hpp"

namespace egomod::bench {

// The pairs to measure on: $EGOMOD_BENCH_SEQUENCE (default rendered_crossing_turn_640) of
// $EGOMOD_DATA_DIR, or the built-in rendered room when that is not set. Throws std::runtime_error
// naming what is missing.
[[nodiscard]] std::vector<StereoPair> load_pairs();
[[nodiscard]] std::string pairs_name();

// The rendered room, 4:3.
[[nodiscard]] std::vector<StereoPair> rendered_pairs(int width_px = 640);

}  // namespace egomod::bench
