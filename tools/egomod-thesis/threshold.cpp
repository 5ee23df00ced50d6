// SPDX-License-Identifier: Apache-2.0
#include "threshold.hpp"

#include <algorithm>
#include <random>

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

std::vector<double> drawn(std::vector<double> values, std::size_t most) {
  std::mt19937 generator;  // NOLINT(bugprone-random-generator-seed): always the same
  for (std::size_t i = 0; i + 1 < values.size() && i < most; ++i) {
    std::swap(values[i], values[i + generator() % (values.size() - i)]);
  }
  values.resize(std::min(values.size(), most));
  return values;
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

fit::Labels drawn(const fit::Labels& labels, std::size_t most) {
  return {drawn(labels.static_mps, most), drawn(labels.moving_mps, most)};
}

std::vector<ThresholdFit> fit_thresholds(const std::vector<std::string>& folders) {
  const fit::Labels agreed = labels_of(folders, fit::PointChoice::kRansac);
  return {fitted("RANSAC's inliers that rest and outliers that move, 450 of each",
                 drawn(agreed, kPublishedSamples)),
          fitted("the same, all of them", agreed),
          fitted("RANSAC's inliers and outliers, wherever they lie",
                 labels_of(folders, fit::PointChoice::kRoles)),
          fitted("all points, by the truth", labels_of(folders, fit::PointChoice::kAll))};
}

}  // namespace egomod::thesis
