// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

namespace egomod {

// What the method filter decides by, beside MovingObjectsConfig: a point moves above both.
inline constexpr double kMovingEvidence = 2.0;    // log likelihood ratio, moving over static
inline constexpr double kMovingChi2 = 11.34;      // 99 %, 3 dof: its velocity against rest
inline constexpr double kMovingAloneChi2 = 50.0;  // of no object: told as moving only then

// The evidence of `count` points together, whose errors correlate by `error_correlation`.
[[nodiscard]] inline double group_evidence(double sum, std::size_t count,
                                           double error_correlation) {
  return sum / (1.0 + error_correlation * std::max(0.0, static_cast<double>(count) - 1.0));
}

// The leaky sum over pairs that confirms an object, with one pair's evidence added.
[[nodiscard]] inline double add_evidence(double sum, double group_evidence) {
  constexpr double kMemory = 0.9;  // of one pair
  constexpr double kMostOfOnePair = 40.0;
  return kMemory * sum + std::clamp(group_evidence, 0.0, kMostOfOnePair);
}

}  // namespace egomod
