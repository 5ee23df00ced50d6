// SPDX-License-Identifier: Apache-2.0
#include "findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace egomod::thesis {
namespace {

using eval::Evaluation;
using eval::FigureTable;
using eval::number;

constexpr double kErrorsGrow_m = 9.0;  // "major errors [...] start to appear after the 9"
constexpr double kPublishedPair_s = 0.41;

std::string metres(const std::optional<double>& value, int decimals = 3) {
  return value ? fmt::format("{:.{}f} m", *value, decimals) : "-";
}

std::string range_of(const Case& one, const Evaluation& evaluation) {
  (void)one;
  const std::vector<Sighting> found = sightings(evaluation);
  if (found.empty()) return "-";
  const auto [near, far] = std::minmax_element(
      found.begin(), found.end(),
      [](const Sighting& a, const Sighting& b) { return a.depth_m < b.depth_m; });
  return fmt::format("{:.3f} to {:.3f} m", near->depth_m, far->depth_m);
}

struct Errors {
  std::optional<eval::Summary> position_m, velocity_mps;
};

Errors errors_of(const std::vector<Sighting>& found, double from_m, double to_m) {
  std::vector<double> position;
  std::vector<double> velocity;
  for (const Sighting& s : found) {
    if (s.depth_m < from_m || s.depth_m >= to_m) continue;
    position.push_back(s.position_error_m);
    velocity.push_back(s.velocity_error_mps);
  }
  return {eval::summarise(position), eval::summarise(velocity)};
}

std::string median_position(const Case& one, const Evaluation& evaluation) {
  (void)one;
  const auto errors = errors_of(sightings(evaluation), 0.0, std::numeric_limits<double>::max());
  return metres(errors.position_m ? std::optional(errors.position_m->median) : std::nullopt);
}

std::string share_found(const Evaluation& evaluation) {
  return number(evaluation.detection->recall, 3);
}

std::string milliseconds(const std::optional<double>& ms) {
  return ms ? fmt::format("{:.1f} ms", *ms) : "-";
}

}  // namespace

std::optional<double> pair_ms(const Evaluation& evaluation) {
  double sum_ms = 0.0;
  for (const auto& [stage, values] : evaluation.estimate.stage_ms) {
    if (stage.rfind("total", 0) == 0) continue;  // holds the time that a pair waits
    if (const auto summary = eval::summarise(values)) sum_ms += summary->mean;
  }
  return sum_ms > 0.0 ? std::optional(sum_ms) : std::nullopt;
}

FigureTable comparison_table(const Cases& cases, const std::vector<ThresholdFit>& fits) {
  const ThresholdFit& fit = fits.front();
  FigureTable table{"The thesis's figures and ours",
                    {"figure", "thesis", "preset thesis, 1 Hz", "default, 30 Hz"},
                    {}};
  const auto add = [&](std::string name, std::string published, std::string thesis,
                       std::string standard) {
    table.rows.push_back(
        {std::move(name), std::move(published), std::move(thesis), std::move(standard)});
  };
  add("threshold, both classes as probable", fmt::format("{} m/s", kPublishedThreshold_mps),
      number(fit.even_mps, 4) + " m/s", "none: evidence");
  add("threshold, 99 % sure", "lost", number(fit.certain_mps, 4) + " m/s", "none");
  add("range", fmt::format("{} to {} m", kPublishedNearest_m, kPublishedFarthest_m),
      range_of(cases.range, cases.range.thesis), range_of(cases.range, cases.range.standard));
  add("time of a pair, 800x600", fmt::format("{} s", kPublishedPair_s),
      milliseconds(pair_ms(cases.moving.thesis)), milliseconds(pair_ms(cases.moving.standard)));
  for (const auto* one : {&cases.still, &cases.moving}) {
    const std::string name = one == &cases.still ? "rig at rest" : "rig moving";
    add(name + ": pairs in which the target was found", "not told", share_found(one->thesis),
        share_found(one->standard));
    add(name + ": median error of its position", "a picture", median_position(*one, one->thesis),
        median_position(*one, one->standard));
  }
  return table;
}

FigureTable threshold_table(const std::vector<ThresholdFit>& fits) {
  FigureTable table{"The threshold by the samples it is fitted to",
                    {"samples", "at rest", "moving", "sigma at rest, m/s", "sigma moving, m/s",
                     "50 %, m/s", "99 %, m/s"},
                    {}};
  for (const ThresholdFit& fit : fits) {
    table.rows.push_back({fit.samples, std::to_string(fit.labels.static_mps.size()),
                          std::to_string(fit.labels.moving_mps.size()),
                          number(fit.model.classifier.sigma_static_mps, 4),
                          number(fit.model.classifier.sigma_moving_mps, 4), number(fit.even_mps, 4),
                          number(fit.certain_mps, 4)});
  }
  return table;
}

FigureTable error_table(const Cases& cases) {
  FigureTable table{"Errors of the target",
                    {"case", "method", "depth, m", "pairs", "position median, m",
                     "position rmse, m", "velocity rmse, m/s"},
                    {}};
  const auto add = [&](const char* name, const char* method, const Evaluation& evaluation,
                       const char* depth, double from_m, double to_m) {
    const auto [position, velocity] = errors_of(sightings(evaluation), from_m, to_m);
    if (!position) return;
    table.rows.push_back({name, method, depth, std::to_string(position->count),
                          number(position->median, 3), number(position->rmse, 3),
                          velocity ? number(velocity->rmse, 3) : "-"});
  };
  for (const auto* one : {&cases.still, &cases.moving}) {
    const char* name = one == &cases.still ? "rig at rest" : "rig moving";
    for (const auto* evaluation : {&one->thesis, &one->standard}) {
      const char* method = evaluation == &one->thesis ? "thesis" : "default";
      add(name, method, *evaluation, "to 9", 0.0, kErrorsGrow_m);
      add(name, method, *evaluation, "from 9", kErrorsGrow_m, std::numeric_limits<double>::max());
    }
  }
  return table;
}

std::vector<Deviation> deviations(const Cases& cases, const std::vector<ThresholdFit>& fits) {
  (void)cases;
  (void)fits;
  return {};
}

}  // namespace egomod::thesis
