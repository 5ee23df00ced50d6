// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/noise_scale.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr double kMedianChi2 = 2.366;  // of the chi-square law with 3 degrees of freedom
constexpr double kGain = 0.15;         // exponent of one pair's say
constexpr double kLeast = 0.5;
constexpr double kMost = 12.0;
constexpr std::size_t kLeastPoints = 30;

}  // namespace

void NoiseScale::learn(std::vector<double>& chi2) {
  misfit_ = std::numeric_limits<double>::infinity();
  if (chi2.size() < kLeastPoints) return;
  const auto middle = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 2);
  std::nth_element(chi2.begin(), middle, chi2.end());
  misfit_ = *middle / kMedianChi2;
  value_ = std::clamp(value_ * std::pow(std::max(misfit_, 0.1), kGain), kLeast, kMost);
}

}  // namespace egomod
