// SPDX-License-Identifier: Apache-2.0
// egomod-fit: what the methods decide by, from labelled velocities or from records with their
// truth.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "filter_model.hpp"
#include "finite_number.hpp"
#include "labels.hpp"
#include "options.hpp"
#include "preset.hpp"
#include "thesis_model.hpp"

namespace egomod::fit {
namespace {

constexpr const char* kWhat =
    "Fits and draws what a method decides by, and writes the configuration.\n"
    "thesis: the Rayleigh laws of static and moving points' speeds, the 50 % and 99 % thresholds "
    "between them.\n"
    "filter: the evidence of points and objects by class, min_evidence, confirm_evidence and "
    "velocity_prior_mps. The cuts of points are built in, and what a record does not hold is not "
    "fitted: noise_floor_px, walk_px, disparity_bias_px, flow_error_share, acceleration_mps2, "
    "manoeuvre_hz, object_chi2, min_purity.";

void add_options(CLI::App& app, Options& options) {
  app.add_option("labels", options.labels,
                 "CSV file with the columns speed_mps and moving (0 or 1); thesis only");
  app.add_option("--method", options.method, "whose decision")
      ->check(CLI::IsMember({"thesis", "filter"}))
      ->capture_default_str();
  app.add_option("--record", options.records,
                 "take a record's EGOMOD_TRACKS instead; may be given more than once. For filter, "
                 "record with moving_objects.min_evidence = 0: what is below it opens no object");
  app.add_option("--truth", options.truths,
                 "folder of the truth (objects.csv, mask_0, ...), once for each record");
  app.add_option("--points", options.points,
                 "thesis: of a record; all: by the truth; ransac: those in which the odometry's "
                 "RANSAC agrees, as its outliers are the thesis's samples of what moves; roles: "
                 "RANSAC's inliers and outliers, without --truth")
      ->check(CLI::IsMember({"all", "ransac", "roles"}))
      ->capture_default_str();
  app.add_option("--preset", options.preset,
                 "configuration to start from: a file of its name is written to the output folder, "
                 "with the fitted keys replaced and all else as it is");
  app.add_option("--output", options.output,
                 "folder for the preset (moving_objects.toml without --preset), the figure and, "
                 "for thesis with --record, labels.csv")
      ->capture_default_str();
  app.add_option("--prior-moving", options.prior_moving,
                 "prior probability that a point moves; thesis: 0.5, both classes alike; filter: "
                 "their share in the records")
      ->check(finite_number())
      ->check(CLI::Range(1e-6, 1.0 - 1e-6));
  app.add_option("--max-speed-mps", options.max_speed_mps,
                 "thesis: leave faster samples out as mismatches; 0: keep all, as the thesis does")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--format", options.format, "format of the figure")
      ->check(CLI::IsMember({"png", "svg"}))
      ->capture_default_str();
  app.add_flag("!--no-plot", options.plot, "draw no figure (gnuplot is not needed then)");
}

void check(const Options& options) {
  const bool filter = options.method == "filter";
  if (filter && !options.labels.empty())
    throw CLI::ValidationError("--method filter: takes --record LOG --truth DIR");
  if (options.labels.empty() == options.records.empty())
    throw CLI::ValidationError("give either LABELS.csv or --record LOG --truth DIR");
  const bool without_truth =
      !options.labels.empty() || (options.points == "roles" && options.truths.empty() && !filter);
  if (options.truths.size() != (without_truth ? 0 : options.records.size())) {
    throw CLI::ValidationError(std::to_string(options.records.size()) + " records but " +
                               std::to_string(options.truths.size()) +
                               " truths; each record needs its own --truth");
  }
}

void run(const Options& options) {
  std::filesystem::create_directories(options.output);
  const FitResult result = options.method == "filter" ? fit_filter(options) : fit_thesis(options);
  write_preset(options, result.keys);
  if (!result.damage.empty()) throw InputError(result.damage + "; what is whole has been used");
  if (std::fflush(stdout) != 0) throw InputError("standard output: cannot be written");
}

}  // namespace
}  // namespace egomod::fit

int main(int argc, char** argv) {
  CLI::App app{egomod::fit::kWhat};
  egomod::fit::Options options;
  egomod::fit::add_options(app, options);
  try {
    app.parse(argc, argv);
    egomod::fit::check(options);
    egomod::fit::run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "egomod-fit: %s\n", error.what());
    return 1;
  }
  return 0;
}
