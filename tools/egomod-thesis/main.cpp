// SPDX-License-Identifier: Apache-2.0
// egomod-thesis: the counterparts of the thesis's figures, from records of its cases.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pages.hpp"
#include "result_file.hpp"

namespace egomod::thesis {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string still, moving, range;
  std::vector<std::string> near;
  std::string output = "report.html";
  std::string summary;
  std::string pictures;
};

void add_options(CLI::App& app, Options& o) {
  const auto add_case = [&](const char* name, std::string& folder, const char* what) {
    app.add_option(name, folder,
                   std::string(what) +
                       ": folder with truth/, thesis.lcmlog, "
                       "default.lcmlog")
        ->required();
  };
  add_case("--still", o.still, "the thesis's first case, rig at rest");
  add_case("--moving", o.moving, "its second case, rig moving");
  add_case("--range", o.range,
           "a target that goes from close by to far away, and thesis-narrow.lcmlog beside");
  app.add_option("--near", o.near,
                 "targets that come near, to find the near end of the range: folders with truth/, "
                 "thesis.lcmlog and thesis-wide.lcmlog")
      ->required();
  app.add_option("--output", o.output, "the report, one HTML file")->capture_default_str();
  auto* summary = app.add_option("--summary", o.summary, "the same in short, as Markdown");
  app.add_option("--pictures", o.pictures,
                 "folder for the figures as SVG files, which the summary shows")
      ->needs(summary);
  summary->needs("--pictures");
}

void write(const fs::path& path, const std::string& text) {
  log::ResultFile result(path);
  std::ofstream file(result.path());
  file << text;
  if (!file.flush()) {
    throw log::OutputError(path.string() + ": cannot be written; does its folder exist, is there " +
                           "space, may you write there?");
  }
  result.keep();
}

void write_summary(const Options& options, const Reproduction& reproduction) {
  std::error_code error;
  fs::create_directories(options.pictures, error);
  for (const auto& [name, plot] : reproduction.pictures.all())
    write(fs::path(options.pictures) / (name + ".svg"), plot->svg);
  const fs::path from = fs::absolute(options.summary).parent_path();
  write(options.summary, markdown_of(reproduction, fs::proximate(options.pictures, from)));
}

Cases read_cases(const Options& options) {
  Cases cases{.still = read_case(options.still),
              .moving = read_case(options.moving),
              .range = read_case(options.range),
              .range_narrow_gate = read_thesis_run(options.range, "thesis-narrow"),
              .near = {},
              .near_wide_search = {}};
  for (const std::string& folder : options.near) {
    cases.near.push_back(read_thesis_run(folder, "thesis"));
    cases.near_wide_search.push_back(read_thesis_run(folder, "thesis-wide"));
  }
  return cases;
}

void run(const Options& options) {
  Reproduction reproduction{.cases = read_cases(options),
                            .fits = fit_thresholds({options.still, options.moving}),
                            .pictures = {}};
  const Cases& cases = reproduction.cases;
  reproduction.pictures = draw_pictures(reproduction.fits.front(), cases.still, cases.moving,
                                        cases.range, cases.range_narrow_gate);
  write(options.output, html_of(reproduction));
  if (!options.summary.empty()) write_summary(options, reproduction);
  std::printf("%s", eval::text_of(comparison_table(cases, reproduction.fits)).c_str());
  if (std::fflush(stdout) != 0) throw log::OutputError("standard output: cannot be written");
}

}  // namespace
}  // namespace egomod::thesis

int main(int argc, char** argv) {
  CLI::App app{
      "Draws the counterparts of the thesis's figures from records of its cases, beside its own "
      "numbers. tools/reproduce-thesis makes the records."};
  egomod::thesis::Options options;
  egomod::thesis::add_options(app, options);
  try {
    app.parse(argc, argv);
    egomod::thesis::run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "egomod-thesis: %s\n", error.what());
    return 1;
  }
  return 0;
}
