// SPDX-License-Identifier: Apache-2.0
#include "thesis_model.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "egomod/moving_objects/rayleigh.hpp"
#include "labels.hpp"
#include "plot.hpp"
#include "record_labels.hpp"

namespace egomod::fit {
namespace {

constexpr double kPublishedThreshold_mps = 0.2385;  // Abaabu, section V-A, the 50 % one
constexpr double kPublishedPrior = 0.5;             // as many samples of each class
// Kolmogorov-Smirnov distances above this are visible to the eye in the plot.
constexpr double kPoorFit = 0.1;

PointChoice choice_of(const std::string& points) {
  if (points == "ransac") return PointChoice::kRansac;
  return points == "roles" ? PointChoice::kRoles : PointChoice::kAll;
}

void append(const std::vector<double>& from, std::vector<double>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

RecordLabels load(const Options& options) {
  if (options.records.empty()) return {.labels = read_labels(options.labels), .damage = {}};
  RecordLabels all;
  for (std::size_t i = 0; i < options.records.size(); ++i) {
    const auto [labels, damage] =
        label_record(options.records[i], options.truths.empty() ? "" : options.truths[i],
                     choice_of(options.points));
    append(labels.static_mps, all.labels.static_mps);
    append(labels.moving_mps, all.labels.moving_mps);
    if (!damage.empty()) all.damage += (all.damage.empty() ? "" : "; ") + damage;
  }
  write_labels(options.output + "/labels.csv", all.labels);
  return all;
}

void drop_mismatches(const char* name, double max_speed_mps, std::vector<double>& speeds_mps) {
  const auto dropped =
      std::erase_if(speeds_mps, [&](double speed_mps) { return speed_mps > max_speed_mps; });
  std::printf("%-7s %7zu samples above %g m/s left out\n", name, dropped, max_speed_mps);
}

void require_samples(const Labels& labels) {
  if (labels.static_mps.empty() || labels.moving_mps.empty()) {
    throw InputError("both classes need samples: " + std::to_string(labels.static_mps.size()) +
                     " static and " + std::to_string(labels.moving_mps.size()) + " moving given");
  }
}

// The daemon takes no smaller scale.
void require_spread(const char* name, double sigma_mps) {
  constexpr double kLeastSigma_mps = 1e-4;
  if (sigma_mps >= kLeastSigma_mps) return;
  throw InputError(std::string("the speeds of the ") + name + " samples are " +
                   "all but 0, no Rayleigh law has such a scale and egomodd takes none below " +
                   "0.0001 m/s: label speeds as measured, noise and all, not true ones");
}

void print_class(const char* name, const std::vector<double>& speeds_mps, double sigma_mps,
                 double distance) {
  std::printf(
      "%-7s %7zu samples   sigma_R %.4f m/s (by the median %.4f)   Kolmogorov-Smirnov distance "
      "%.3f%s\n",
      name, speeds_mps.size(), sigma_mps, median_rayleigh(speeds_mps), distance,
      distance > kPoorFit ? "  (not a Rayleigh law: look at the figure)" : "");
}

void print_threshold(const RayleighClassifier& classifier, double probability) {
  if (const auto threshold = speed_threshold(classifier, probability)) {
    std::printf("%2.0f %% threshold   %.4f m/s\n", 100 * probability, *threshold);
  }
}

void print(const Labels& labels, const RayleighFit& fit) {
  print_class("static", labels.static_mps, fit.classifier.sigma_static_mps, fit.distance_static);
  print_class("moving", labels.moving_mps, fit.classifier.sigma_moving_mps, fit.distance_moving);
  print_threshold(fit.classifier, 0.5);
  print_threshold(fit.classifier, 0.99);
  std::printf("(published 50 %% threshold: %.4f m/s)\n", kPublishedThreshold_mps);
}

}  // namespace

FitResult fit_thesis(const Options& options) {
  auto [labels, damage] = load(options);
  if (options.max_speed_mps > 0.0) {
    drop_mismatches("static", options.max_speed_mps, labels.static_mps);
    drop_mismatches("moving", options.max_speed_mps, labels.moving_mps);
  }
  require_samples(labels);
  std::sort(labels.static_mps.begin(), labels.static_mps.end());
  std::sort(labels.moving_mps.begin(), labels.moving_mps.end());
  const RayleighFit fit = fit_classifier(labels.static_mps, labels.moving_mps,
                                         options.prior_moving.value_or(kPublishedPrior));
  const RayleighClassifier& classifier = fit.classifier;
  require_spread("static", classifier.sigma_static_mps);
  require_spread("moving", classifier.sigma_moving_mps);
  print(labels, fit);
  if (options.plot) {
    std::printf("wrote %s\n", draw_figure(options.output, options.format, labels, fit).c_str());
  }
  const auto threshold = speed_threshold(classifier, 0.5);
  if (!threshold) {
    throw InputError(
        "moving points are not faster than static ones, no threshold divides them: are the labels "
        "right, do mismatches dominate (--max-speed-mps), is the rate low enough?");
  }
  return {.keys = {{"threshold_mps", *threshold},
                   {"sigma_static_mps", classifier.sigma_static_mps},
                   {"sigma_moving_mps", classifier.sigma_moving_mps},
                   {"prior_moving", classifier.prior_moving}},
          .damage = damage};
}

}  // namespace egomod::fit
