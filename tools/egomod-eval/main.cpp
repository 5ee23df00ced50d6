// SPDX-License-Identifier: Apache-2.0
// egomod-eval: how good a run was, by the truth.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "evaluation.hpp"
#include "figure_tables.hpp"
#include "finite_number.hpp"
#include "html.hpp"
#include "json.hpp"
#include "result_file.hpp"
#include "tables.hpp"

namespace egomod::eval {
namespace {

struct Options {
  std::vector<std::string> truths, records, results, poses, names, methods, pairs;
  std::string format = "kitti";
  std::string output;
  std::string json;
  std::string markdown;
  bool brief = false;
  DetectionOptions detection;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("--truth", o.truths,
                 "folder of the truth: times.txt, poses.txt, objects.csv, calib.txt, mask_0, "
                 "depth_0, as far "
                 "as they are there; once for each run; records of --source sim hold their own");
  app.add_option("--record", o.records, "record of egomodd, one for each truth");
  app.add_option("--result", o.results,
                 "folder as egomod-log export writes it, one for each truth");
  app.add_option("--poses", o.poses, "file of left camera poses, one for each truth");
  app.add_option(
         "--format", o.format,
         "of --poses; kitti: 12 numbers a row (13: frame first); tum: time tx ty tz qx qy qz qw")
      ->check(CLI::IsMember({"kitti", "tum"}))
      ->capture_default_str();
  app.add_option("--name", o.names, "what the report calls each run (default: the truth's folder)");
  app.add_option("--method", o.methods, "a label for each run, for --markdown");
  app.add_option("--pairs", o.pairs,
                 "all, or those that a record processed (a run at a lower rate than its truth's); "
                 "one for all runs, or one for each")
      ->check(CLI::IsMember({"all", "processed"}));
  app.add_option("--output", o.output, "folder for report.html and figures.json; made if needed");
  app.add_option("--json", o.json,
                 "write all figures to this file; - is standard output, no tables");
  app.add_option(
      "--markdown", o.markdown,
      "write a table of worlds and methods to this file: a row for each run, then means");
  app.add_flag("--brief", o.brief, "print the headline figures only");
  app.add_option("--every", o.detection.every,
                 "objects: only frames divisible by this count (a run at a lower rate)")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--max-depth", o.detection.max_depth_m, "objects: due up to this depth, m")
      ->check(finite_number())
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--min-px", o.detection.min_px, "objects: due from this many visible pixels on")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--grace", o.detection.grace_s,
                 "objects: due this many seconds after they qualify")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option(
         "--v90", o.detection.v90_factor,
         "objects: due from this many times the speed that can show within 1 s; 0: any mover")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

bool counts_processed_only(const std::vector<std::string>& pairs, std::size_t run) {
  return !pairs.empty() && pairs[pairs.size() == 1 ? 0 : run] == "processed";
}

std::vector<Run> runs_of(const Options& o) {
  const bool one_kind =
      (o.records.empty() ? 0 : 1) + (o.results.empty() ? 0 : 1) + (o.poses.empty() ? 0 : 1) == 1;
  if (!one_kind) throw CLI::ValidationError("give one of --record, --result, --poses");
  const EstimateKind kind = !o.records.empty()   ? EstimateKind::kRecord
                            : !o.results.empty() ? EstimateKind::kResult
                                                 : EstimateKind::kPoses;
  const auto& estimates = !o.records.empty() ? o.records : !o.results.empty() ? o.results : o.poses;
  const bool hold_truth = o.truths.empty() && kind == EstimateKind::kRecord;
  if (!hold_truth && estimates.size() != o.truths.size()) {
    throw CLI::ValidationError(std::to_string(estimates.size()) + " runs but " +
                               std::to_string(o.truths.size()) + " truths; each run needs its own");
  }
  if (!o.names.empty() && o.names.size() != estimates.size())
    throw CLI::ValidationError("--name: one for each run, or none");
  if (!o.methods.empty() && o.methods.size() != estimates.size())
    throw CLI::ValidationError("--method: one for each run, or none");
  if (o.pairs.size() > 1 && o.pairs.size() != estimates.size())
    throw CLI::ValidationError("--pairs: one for all runs, or one for each");
  if (kind != EstimateKind::kRecord && !o.pairs.empty())
    throw CLI::ValidationError("--pairs: of --record only");
  std::vector<Run> runs;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    runs.push_back({.name = o.names.empty() ? "" : o.names[i],
                    .truth = hold_truth ? "" : o.truths[i],
                    .estimate = estimates[i],
                    .kind = kind,
                    .format = o.format == "tum" ? PoseFormat::kTum : PoseFormat::kKitti,
                    .method = o.methods.empty() ? "" : o.methods[i],
                    .processed_only = counts_processed_only(o.pairs, i)});
  }
  return runs;
}

void write(const std::filesystem::path& path, const std::string& text) {
  log::ResultFile result(path);
  std::ofstream file(result.path());
  file << text;
  if (!file.flush()) throw InputError(path.string() + ": cannot be written");
  result.keep();
}

// One run in a list, several in a table.
void print_brief(const std::vector<Evaluation>& evaluations) {
  const bool one = evaluations.size() == 1;
  const FigureTable table = one ? headlines(evaluations.front()) : overview(evaluations);
  std::printf("%s", text_of(table).c_str());
  for (const Evaluation& e : evaluations) {
    for (const std::string& note : e.notes)
      std::printf("Note: %s: %s\n", e.name.c_str(), note.c_str());
  }
}

void print(const std::vector<Evaluation>& evaluations) {
  for (const Evaluation& e : evaluations) {
    std::printf("=== %s (%s)\n", e.name.c_str(), e.source.c_str());
    for (const FigureTable& table : figure_tables(e)) std::printf("%s\n", text_of(table).c_str());
    for (const std::string& note : e.notes) std::printf("Note: %s\n", note.c_str());
    if (!e.notes.empty()) std::printf("\n");
  }
  if (evaluations.size() > 1) std::printf("%s\n", text_of(overview(evaluations)).c_str());
}

void report(const std::vector<Evaluation>& evaluations, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder + ": cannot be made: " + error.message());
  const HtmlReport html = html_report(evaluations);
  write(std::filesystem::path(folder) / "report.html", html.text);
  write(std::filesystem::path(folder) / "figures.json", json_of(evaluations));
  if (!html.warning.empty()) std::fprintf(stderr, "egomod-eval: %s\n", html.warning.c_str());
  std::fprintf(stderr, "wrote %s/report.html and figures.json\n", folder.c_str());
}

void run(const Options& options, const std::vector<Run>& runs) {
  std::vector<Evaluation> evaluations;
  evaluations.reserve(runs.size());
  for (const Run& one : runs) evaluations.push_back(evaluate(one, options.detection));
  if (options.json == "-") {
    std::printf("%s", json_of(evaluations).c_str());
  } else {
    options.brief ? print_brief(evaluations) : print(evaluations);
    if (!options.json.empty()) write(options.json, json_of(evaluations));
  }
  if (!options.markdown.empty()) write(options.markdown, markdown_of(method_table(evaluations)));
  if (!options.output.empty()) report(evaluations, options.output);
  if (std::fflush(stdout) != 0) throw InputError("standard output: cannot be written");
}

}  // namespace
}  // namespace egomod::eval

int main(int argc, char** argv) {
  CLI::App app{"Scores poses and moving objects against the truth; several runs make one table."};
  egomod::eval::Options options;
  egomod::eval::add_options(app, options);
  try {
    app.parse(argc, argv);
    egomod::eval::run(options, egomod::eval::runs_of(options));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "egomod-eval: %s\n", error.what());
    return 1;
  }
  return 0;
}
