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

// From the thesis's runs in these folders. The first are the thesis's samples, but all that there
// are: RANSAC's inliers that rest and its outliers that move.
[[nodiscard]] std::vector<ThresholdFit> fit_thresholds(const std::vector<std::string>& folders);

// The 50 % threshold if only so many of each class are drawn at random, over many such draws;
// always the same.
struct ThresholdSpread {
  int draws = 0;
  double low_mps = 0.0, median_mps = 0.0, high_mps = 0.0;  // 5, 50 and 95 % of the draws are below
};
[[nodiscard]] ThresholdSpread spread_of(const fit::Labels& labels, std::size_t samples);

}  // namespace egomod::thesis
