// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

namespace egomod {

// The thesis's classifier of points by their speed: Rayleigh likelihoods for both classes, Bayes'
// rule between them (Abaabu, section IV-B and eqs. 30-33).
struct RayleighClassifier {
  double sigma_static_mps = 0.0;
  double sigma_moving_mps = 0.0;
  double prior_moving = 0.5;
};

[[nodiscard]] double rayleigh_density(double speed_mps, double sigma_mps);  // eq. 32
[[nodiscard]] double rayleigh_cumulative(double speed_mps, double sigma_mps);
// Maximum likelihood scale, eq. 33. 0 without samples.
[[nodiscard]] double fit_rayleigh(std::span<const double> speeds_mps);
// The scale whose median is the samples': a few mismatches among them do not move it, as they do
// eq. 33. `speeds_mps` must ascend and hold a sample.
[[nodiscard]] double median_rayleigh(std::span<const double> speeds_mps);
// Largest distance between the samples' distribution and the Rayleigh law (Kolmogorov-Smirnov).
// `speeds_mps` must ascend.
[[nodiscard]] double rayleigh_distance(std::span<const double> speeds_mps, double sigma_mps);

// P(moving | speed), eqs. 30-31.
[[nodiscard]] double moving_posterior(const RayleighClassifier& classifier, double speed_mps);
// The speed from which on P(moving | speed) >= probability: 0 when it holds at rest, nothing when
// moving points are not faster than static ones (sigma_moving <= sigma_static).
[[nodiscard]] std::optional<double> speed_threshold(const RayleighClassifier& classifier,
                                                    double probability);

// What the two classes' speeds say: the classifier and how far each class is from its Rayleigh law.
struct RayleighFit {
  RayleighClassifier classifier;
  double distance_static = 0.0;
  double distance_moving = 0.0;
};
// Both spans must ascend and hold a sample.
[[nodiscard]] RayleighFit fit_classifier(std::span<const double> static_speeds_mps,
                                         std::span<const double> moving_speeds_mps,
                                         double prior_moving);

}  // namespace egomod
