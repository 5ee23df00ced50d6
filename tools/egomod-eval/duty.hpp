// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "detection.hpp"

namespace egomod::eval {

// The frames that count, and how often one comes.
[[nodiscard]] std::vector<int> counted_frames(int frames, const DetectionOptions& options);
[[nodiscard]] double counted_rate_hz(const Truth& truth, const DetectionOptions& options);

// For each object of each counted frame, parallel to the truth's lists.
[[nodiscard]] std::map<int, std::vector<Duty>> duties(const Truth& truth,
                                                      const std::vector<int>& counted,
                                                      const DetectionOptions& options);

}  // namespace egomod::eval
