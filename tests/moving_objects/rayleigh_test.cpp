// SPDX-License-Identifier: Apache-2.0
#include "egomod/moving_objects/rayleigh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "egomod/moving_objects/moving_objects_config.hpp"

namespace egomod {
namespace {

std::vector<double> rayleigh_samples(double sigma, int count) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> samples;
  for (int k = 0; k < count; ++k) samples.push_back(std::hypot(normal(random), normal(random)));
  std::sort(samples.begin(), samples.end());
  return samples;
}

TEST(Rayleigh, FitRecoversTheScale) {
  constexpr int kSamples = 20000;
  const double standard_error = 0.3 / std::sqrt(4.0 * kSamples);
  EXPECT_NEAR(fit_rayleigh(rayleigh_samples(0.3, kSamples)), 0.3, 4 * standard_error);
}

TEST(Rayleigh, MedianScaleStandsAFewMismatches) {
  std::vector<double> samples = rayleigh_samples(0.3, 20000);
  for (std::size_t i = samples.size() - 100; i < samples.size(); ++i) samples[i] = 50.0;
  EXPECT_NEAR(median_rayleigh(samples), 0.3, 0.01);
  EXPECT_GT(fit_rayleigh(samples), 2.0);
}

TEST(Rayleigh, DensityIsTheSlopeOfTheCumulative) {
  const double h = 1e-6;
  for (const double x : {0.05, 0.3, 1.1}) {
    const double slope =
        (rayleigh_cumulative(x + h, 0.3) - rayleigh_cumulative(x - h, 0.3)) / (2 * h);
    EXPECT_NEAR(rayleigh_density(x, 0.3), slope, 1e-6);
  }
}

TEST(Rayleigh, DistanceIsSmallForItsOwnLawAndLargeForAnother) {
  const std::vector<double> samples = rayleigh_samples(0.3, 2000);
  EXPECT_LT(rayleigh_distance(samples, fit_rayleigh(samples)), 0.03);
  const std::vector<double> constant(2000, 0.3);
  EXPECT_GT(rayleigh_distance(constant, fit_rayleigh(constant)), 0.3);
}

TEST(Rayleigh, PosteriorIsBayesRuleOnBothDensities) {
  const RayleighClassifier classifier{0.1, 0.3, 0.2};
  for (const double x : {0.05, 0.2, 0.5}) {
    const double moving = 0.2 * rayleigh_density(x, 0.3);
    const double still = 0.8 * rayleigh_density(x, 0.1);
    EXPECT_NEAR(moving_posterior(classifier, x), moving / (moving + still), 1e-12);
  }
}

TEST(Rayleigh, ThresholdsSolveThePosteriorEquation) {
  for (const double prior : {0.1, 0.5, 0.8}) {
    const RayleighClassifier classifier{0.1, 0.3, prior};
    for (const double probability : {0.5, 0.99}) {
      const auto threshold = speed_threshold(classifier, probability);
      ASSERT_TRUE(threshold.has_value());
      EXPECT_NEAR(moving_posterior(classifier, *threshold), probability, 1e-12);
    }
  }
}

TEST(Rayleigh, ThresholdIsZeroWhenThePriorAlreadyDecides) {
  EXPECT_EQ(speed_threshold({0.1, 0.11, 0.99}, 0.5), 0.0);
}

TEST(Rayleigh, NoThresholdWhenMovingPointsAreNotFaster) {
  EXPECT_FALSE(speed_threshold({0.3, 0.1, 0.5}, 0.5).has_value());
  EXPECT_FALSE(speed_threshold({0.3, 0.3, 0.5}, 0.5).has_value());
}

TEST(Rayleigh, DefaultScalesMeetAtThePublishedThreshold) {
  const MovingObjectsConfig config;
  const auto threshold =
      speed_threshold({config.sigma_static_mps, config.sigma_moving_mps, config.prior_moving},
                      config.decision_probability);
  EXPECT_NEAR(threshold.value(), 0.2385, 1e-4);
}

}  // namespace
}  // namespace egomod
