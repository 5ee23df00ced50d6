// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "egomod/moving_objects/rayleigh.hpp"
#include "labels.hpp"

namespace egomod::thesis {

constexpr double kPublishedThreshold_mps = 0.2385;
constexpr double kPublishedNearest_m = 0.866;
constexpr double kPublishedFarthest_m = 13.537;
// "450 samples for random inliers velocities and the same number for outliers velocities".
constexpr std::size_t kPublishedSamples = 450;

// The decision model that one choice of samples gives.
struct ThresholdFit {
  std::string samples;  // which
  fit::Labels labels;   // each class ascending
  RayleighFit model;
  std::optional<double> even_mps;     // where both classes are as probable
  std::optional<double> certain_mps;  // where motion is 99 % probable
};

// From the thesis's runs in these folders. The first is the published one: RANSAC's inliers that
// rest and its outliers that move, as many as the thesis took, drawn at random, always the same.
[[nodiscard]] std::vector<ThresholdFit> fit_thresholds(const std::vector<std::string>& folders);
// At most so many of each class, drawn at random, always the same.
[[nodiscard]] fit::Labels drawn(const fit::Labels& labels, std::size_t most);

}  // namespace egomod::thesis
