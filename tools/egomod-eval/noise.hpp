// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "record.hpp"

namespace egomod::eval {

// Standard deviations of resting tracks' left positions (along each axis) and disparities.
struct NoisePair {
  double pixel_px = 0.0;
  double disparity_px = 0.0;
};

// One range of depths: what the daemon has learnt, and what the truth says: the whole error since a
// track's first sight, and what of it changes over a track's life, as far as a filter can see it.
// Robust: 1.4826 times the median of the errors' magnitudes.
struct NoiseFigures {
  double from_m = 0.0, to_m = 0.0;  // to 0: no limit
  NoisePair learnt;
  NoisePair whole;
  NoisePair varying;
  int observations = 0;  // of the truth
};

// Ranges of which both are known: needs EGOMOD_TRACKS, and of the truth poses, mask_0 and depth_0.
[[nodiscard]] std::vector<NoiseFigures> score_noise(const Truth& truth, const Record& record,
                                                    int first_frame);

}  // namespace egomod::eval
