// SPDX-License-Identifier: Apache-2.0
// egomod-fit: the thesis's two Rayleigh laws and its thresholds from labelled point velocities.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "egomod/moving_objects/rayleigh.hpp"
#include "labels.hpp"
#include "plot.hpp"
#include "record_labels.hpp"
#include "result_file.hpp"

namespace egomod::fit {
namespace {

constexpr double kPublishedThreshold_mps = 0.2385;  // Abaabu, section V-A, the 50 % one
// Kolmogorov-Smirnov distances above this are visible to the eye in the plot.
constexpr double kPoorFit = 0.1;

struct Options {
  std::string labels;
  std::string record;
  std::string truth;
  std::string points = "all";
  std::string output = ".";
  std::string format = "png";
  double prior_moving = 0.5;
  double max_speed_mps = 0.0;
  bool plot = true;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("labels", options.labels,
                 "CSV file with the columns speed_mps and moving (0 or 1)");
  app.add_option("--record", options.record,
                 "take the velocities from this record's EGOMOD_TRACKS instead; needs --truth");
  app.add_option("--truth", options.truth,
                 "folder with the objects.csv that tells what moves in the record");
  app.add_option("--points", options.points,
                 "of a record; all: by the truth; ransac: those in which the odometry's RANSAC "
                 "agrees, as its outliers are the thesis's samples of what moves; roles: RANSAC's "
                 "inliers and outliers, whatever the truth says")
      ->check(CLI::IsMember({"all", "ransac", "roles"}))
      ->capture_default_str();
  app.add_option("--output", options.output,
                 "folder for moving_objects.toml, the figure and, with --record, labels.csv")
      ->capture_default_str();
  app.add_option("--prior-moving", options.prior_moving,
                 "prior probability that a point moves; 0.5: both classes alike")
      ->check(CLI::Range(1e-6, 1.0 - 1e-6))
      ->capture_default_str();
  app.add_option("--max-speed-mps", options.max_speed_mps,
                 "leave faster samples out as mismatches; 0: keep all, as the thesis does")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--format", options.format, "format of the figure")
      ->check(CLI::IsMember({"png", "svg"}))
      ->capture_default_str();
  app.add_flag("!--no-plot", options.plot, "draw no figure (gnuplot is not needed then)");
}

PointChoice choice_of(const std::string& points) {
  if (points == "ransac") return PointChoice::kRansac;
  return points == "roles" ? PointChoice::kRoles : PointChoice::kAll;
}

RecordLabels load(const Options& options) {
  if (options.record.empty()) return {.labels = read_labels(options.labels), .damage = {}};
  RecordLabels result = label_record(options.record, options.truth, choice_of(options.points));
  write_labels(options.output + "/labels.csv", result.labels);
  return result;
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

void write_configuration(const std::string& path, const RayleighClassifier& classifier,
                         double threshold_mps) {
  log::ResultFile result(path);
  std::ofstream file(result.path());
  file << "[moving_objects]\nthreshold_mps = " << threshold_mps
       << "\nsigma_static_mps = " << classifier.sigma_static_mps
       << "\nsigma_moving_mps = " << classifier.sigma_moving_mps
       << "\nprior_moving = " << classifier.prior_moving << "\n";
  if (!file.flush()) throw InputError(path + ": cannot be written");
  result.keep();
  std::printf("wrote %s\n", path.c_str());
}

void run(const Options& options) {
  std::filesystem::create_directories(options.output);
  auto [labels, damage] = load(options);
  if (options.max_speed_mps > 0.0) {
    drop_mismatches("static", options.max_speed_mps, labels.static_mps);
    drop_mismatches("moving", options.max_speed_mps, labels.moving_mps);
  }
  require_samples(labels);
  std::sort(labels.static_mps.begin(), labels.static_mps.end());
  std::sort(labels.moving_mps.begin(), labels.moving_mps.end());
  const RayleighFit fit =
      fit_classifier(labels.static_mps, labels.moving_mps, options.prior_moving);
  print(labels, fit);
  if (options.plot) {
    std::printf("wrote %s\n", draw_figure(options.output, options.format, labels, fit).c_str());
  }
  const auto threshold = speed_threshold(fit.classifier, 0.5);
  if (!threshold) {
    throw InputError(
        "moving points are not faster than static ones, no threshold divides them: are the labels "
        "right, do mismatches dominate (--max-speed-mps), is the rate low enough?");
  }
  write_configuration(options.output + "/moving_objects.toml", fit.classifier, *threshold);
  if (!damage.empty()) throw InputError(damage + "; what is whole has been used");
  if (std::fflush(stdout) != 0) throw InputError("standard output: cannot be written");
}

}  // namespace
}  // namespace egomod::fit

int main(int argc, char** argv) {
  CLI::App app{
      "Estimates the Rayleigh laws of static and moving points' speeds, the 50 % and 99 % "
      "thresholds between them, and draws both."};
  egomod::fit::Options options;
  egomod::fit::add_options(app, options);
  try {
    app.parse(argc, argv);
    if (options.labels.empty() == options.record.empty() ||
        options.record.empty() != options.truth.empty()) {
      throw CLI::ValidationError("give either LABELS.csv or --record LOG --truth DIR");
    }
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
