// SPDX-License-Identifier: Apache-2.0
#include "filter_model.hpp"

#include <cmath>
#include <cstdio>

#include "egomod/moving_objects/evidence_gates.hpp"
#include "evidence_plot.hpp"
#include "labels.hpp"

namespace egomod::fit {
namespace {

// Fewer samples of movers' velocities say little about all of them.
constexpr std::size_t kLeastVelocities = 100;

FittedCut fitted_cut(const ClassValues& values, double prior_moving, double present) {
  return {present, best_cut(values, prior_moving, present)};
}

void print_score(const char* what, const Score& score) {
  std::printf("  %-34s precision %.4f   recall %.4f   F1 %.4f\n", what, score.precision(),
              score.recall(), score.f1());
}

void print_cut(const char* name, const ClassValues& values, const FittedCut& cut) {
  char text[64];
  const auto line = [&](double at, const char* which) {
    std::snprintf(text, sizeof text, "%s > %.4g, %s", name, at, which);
    print_score(text, score_above(values, at));
  };
  line(cut.present, "in force");
  if (!cut.best) {
    std::printf("  no %s fits: %zu static and %zu moving, which no cut divides\n", name,
                values.still.size(), values.moving.size());
  } else if (*cut.best == cut.present) {
    std::printf("  %s: what is in force is among the best\n", name);
  } else {
    line(*cut.best, "fitted");
  }
}

void print_model(const FilterSamples& samples, const FilterModel& model) {
  std::printf("points, each in each pair: %zu static, %zu moving\n", samples.evidence.still.size(),
              samples.evidence.moving.size());
  print_score("as decided", samples.decided);
  print_cut("evidence", samples.evidence, model.evidence);
  print_cut("chi2", samples.chi2, model.chi2);
  std::printf("objects, over their lives: %zu of what rests, %zu of what moves\n",
              samples.pair_evidence.still.size(), samples.pair_evidence.moving.size());
  print_cut("min_evidence", samples.pair_evidence, model.min_evidence);
  print_cut("confirm_evidence", samples.summed_evidence, model.confirm_evidence);
  if (!model.velocity_prior_mps) {
    std::printf(
        "velocity_prior_mps: not fitted, %zu velocities of movers, mean square %.4g "
        "(m/s)^2 along an axis beyond the rig's\n",
        samples.velocities, samples.velocity_variance_m2ps2);
  } else {
    std::printf("velocity_prior_mps: %.4g m/s, of %zu velocities of movers\n",
                *model.velocity_prior_mps, samples.velocities);
  }
}

}  // namespace

FilterModel fit_model(const FilterSamples& samples, const MovingObjectsConfig& config,
                      std::optional<double> prior_moving) {
  const double of_points = prior_moving.value_or(samples.evidence.share_moving());
  const auto of_objects = [&](const ClassValues& values, double present) {
    return fitted_cut(values, values.share_moving(), present);  // the fewest errors
  };
  FilterModel model{
      .evidence = fitted_cut(samples.evidence, of_points, kMovingEvidence),
      .chi2 = fitted_cut(samples.chi2, of_points, kMovingChi2),
      .min_evidence = of_objects(samples.pair_evidence, config.min_evidence),
      .confirm_evidence = of_objects(samples.summed_evidence, config.confirm_evidence),
      .velocity_prior_mps = std::nullopt};
  if (samples.velocities >= kLeastVelocities && samples.velocity_variance_m2ps2 > 0.0)
    model.velocity_prior_mps = std::sqrt(samples.velocity_variance_m2ps2);
  return model;
}

FitResult fit_filter(const Options& options) {
  const MovingObjectsConfig config;
  FilterSamples samples;
  FitResult result;
  for (std::size_t i = 0; i < options.records.size(); ++i) {
    const std::string damage =
        add_record(options.records[i], options.truths[i], config.error_correlation, samples);
    if (!damage.empty()) result.damage += (result.damage.empty() ? "" : "; ") + damage;
  }
  samples.sort();
  if (samples.evidence.still.empty() || samples.evidence.moving.empty()) {
    throw InputError("both classes need samples: " + std::to_string(samples.evidence.still.size()) +
                     " static and " + std::to_string(samples.evidence.moving.size()) +
                     " moving points were found");
  }
  const FilterModel model = fit_model(samples, config, options.prior_moving);
  print_model(samples, model);
  if (options.plot) {
    std::printf("wrote %s\n",
                draw_evidence(options.output, options.format, samples, model).c_str());
  }
  const auto add = [&](const char* name, const std::optional<double>& value) {
    if (value) result.keys.push_back({name, *value});
  };
  add("velocity_prior_mps", model.velocity_prior_mps);
  add("min_evidence", model.min_evidence.best);
  add("confirm_evidence", model.confirm_evidence.best);
  return result;
}

}  // namespace egomod::fit
