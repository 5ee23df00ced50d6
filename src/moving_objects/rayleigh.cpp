// SPDX-License-Identifier: Apache-2.0
#include "egomod/moving_objects/rayleigh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace egomod {
namespace {

double log_odds(double probability) { return std::log(probability / (1.0 - probability)); }

// ln of the posterior odds is a + b * speed^2: the speed itself cancels out of both densities.
struct LogOdds {
  double at_rest;
  double per_speed2;
};

LogOdds posterior_log_odds(const RayleighClassifier& c) {
  const double s2 = c.sigma_static_mps * c.sigma_static_mps;
  const double m2 = c.sigma_moving_mps * c.sigma_moving_mps;
  return {log_odds(c.prior_moving) + std::log(s2 / m2), 0.5 * (1.0 / s2 - 1.0 / m2)};
}

}  // namespace

double rayleigh_density(double speed_mps, double sigma_mps) {
  const double s2 = sigma_mps * sigma_mps;
  return speed_mps <= 0.0 ? 0.0 : speed_mps / s2 * std::exp(-0.5 * speed_mps * speed_mps / s2);
}

double rayleigh_cumulative(double speed_mps, double sigma_mps) {
  const double x = speed_mps / sigma_mps;
  return speed_mps <= 0.0 ? 0.0 : -std::expm1(-0.5 * x * x);
}

double fit_rayleigh(std::span<const double> speeds_mps) {
  double sum = 0.0;
  for (const double speed : speeds_mps) sum += speed * speed;
  return speeds_mps.empty() ? 0.0 : std::sqrt(0.5 * sum / static_cast<double>(speeds_mps.size()));
}

double median_rayleigh(std::span<const double> speeds_mps) {
  return speeds_mps[speeds_mps.size() / 2] / std::sqrt(2.0 * std::numbers::ln2);
}

double rayleigh_distance(std::span<const double> speeds_mps, double sigma_mps) {
  const auto n = static_cast<double>(speeds_mps.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < speeds_mps.size(); ++i) {
    const double law = rayleigh_cumulative(speeds_mps[i], sigma_mps);
    const auto below = static_cast<double>(i);
    distance = std::max({distance, law - below / n, (below + 1.0) / n - law});
  }
  return distance;
}

double moving_posterior(const RayleighClassifier& classifier, double speed_mps) {
  const auto [at_rest, per_speed2] = posterior_log_odds(classifier);
  return 1.0 / (1.0 + std::exp(-(at_rest + per_speed2 * speed_mps * speed_mps)));
}

std::optional<double> speed_threshold(const RayleighClassifier& classifier, double probability) {
  const auto [at_rest, per_speed2] = posterior_log_odds(classifier);
  if (!(per_speed2 > 0.0)) return std::nullopt;
  return std::sqrt(std::max(0.0, (log_odds(probability) - at_rest) / per_speed2));
}

RayleighFit fit_classifier(std::span<const double> static_speeds_mps,
                           std::span<const double> moving_speeds_mps, double prior_moving) {
  RayleighFit fit;
  fit.classifier = {fit_rayleigh(static_speeds_mps), fit_rayleigh(moving_speeds_mps), prior_moving};
  fit.distance_static = rayleigh_distance(static_speeds_mps, fit.classifier.sigma_static_mps);
  fit.distance_moving = rayleigh_distance(moving_speeds_mps, fit.classifier.sigma_moving_mps);
  return fit;
}

}  // namespace egomod
