// SPDX-License-Identifier: Apache-2.0
#include "threshold.hpp"

#include <algorithm>
#include <random>
#include <span>

#include "record_labels.hpp"

namespace egomod::thesis {
namespace {

constexpr double kEven = 0.5;
constexpr double kCertain = 0.99;

void append(const std::vector<double>& from, std::vector<double>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

fit::Labels labels_of(const std::vector<std::string>& folders, fit::PointChoice choice) {
  fit::Labels all;
  for (const std::string& folder : folders) {
    const auto [labels, damage] =
        fit::label_record(folder + "/thesis.lcmlog", folder + "/truth", choice);
    if (!damage.empty()) throw fit::InputError(damage);
    append(labels.static_mps, all.static_mps);
    append(labels.moving_mps, all.moving_mps);
  }
  return all;
}

// The first of `values` after a shuffle of as many.
std::span<const double> draw(std::vector<double>& values, std::size_t samples,
                             std::mt19937& generator) {
  const std::size_t count = std::min(values.size(), samples);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(values[i], values[i + generator() % (values.size() - i)]);
  return {values.data(), count};
}

ThresholdFit fitted(std::string samples, fit::Labels labels) {
  if (labels.static_mps.empty() || labels.moving_mps.empty()) {
    throw fit::InputError("no threshold from " + samples + ": " +
                          std::to_string(labels.static_mps.size()) + " points at rest and " +
                          std::to_string(labels.moving_mps.size()) + " that move");
  }
  std::sort(labels.static_mps.begin(), labels.static_mps.end());
  std::sort(labels.moving_mps.begin(), labels.moving_mps.end());
  const RayleighFit model = fit_classifier(labels.static_mps, labels.moving_mps, kEven);
  return {.samples = std::move(samples),
          .labels = std::move(labels),
          .model = model,
          .even_mps = speed_threshold(model.classifier, kEven),
          .certain_mps = speed_threshold(model.classifier, kCertain)};
}

}  // namespace

ThresholdSpread spread_of(const fit::Labels& labels, std::size_t samples) {
  constexpr int kDraws = 1000;
  std::mt19937 generator;  // seeded alike each time: the same labels, the same spread
  fit::Labels left = labels;
  std::vector<double> thresholds_mps;
  for (int i = 0; i < kDraws; ++i) {
    const RayleighClassifier model{fit_rayleigh(draw(left.static_mps, samples, generator)),
                                   fit_rayleigh(draw(left.moving_mps, samples, generator)), kEven};
    if (const auto threshold = speed_threshold(model, kEven)) thresholds_mps.push_back(*threshold);
  }
  std::sort(thresholds_mps.begin(), thresholds_mps.end());
  if (thresholds_mps.empty()) return {};
  const auto below = [&](double share) {
    return thresholds_mps[static_cast<std::size_t>(share *
                                                   static_cast<double>(thresholds_mps.size() - 1))];
  };
  return {.draws = static_cast<int>(thresholds_mps.size()),
          .low_mps = below(0.05),
          .median_mps = below(0.5),
          .high_mps = below(0.95)};
}

std::vector<ThresholdFit> fit_thresholds(const std::vector<std::string>& folders) {
  return {fitted("RANSAC's inliers that rest and outliers that move",
                 labels_of(folders, fit::PointChoice::kRansac)),
          fitted("RANSAC's inliers and outliers, wherever they lie",
                 labels_of(folders, fit::PointChoice::kRoles)),
          fitted("all points, by the truth", labels_of(folders, fit::PointChoice::kAll))};
}

}  // namespace egomod::thesis
