// SPDX-License-Identifier: Apache-2.0
// The parts of tools/demo that are not the daemon's: a sequence with exact truth, and the summary.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "compare.hpp"
#include "render.hpp"

namespace {

using egomod::demo::RenderOptions;

struct CompareOptions {
  std::string sequence;
  std::string result;
  double elapsed_ms = 0.0;
};

CLI::App* add_render(CLI::App& app, RenderOptions& options) {
  auto* command = app.add_subcommand("render", "render a stereo sequence with exact truth");
  command->add_option("folder", options.folder, "where to (KITTI odometry layout)")->required();
  command->add_option("--scene", options.scene)
      ->check(CLI::IsMember(egomod::demo::scene_names()))
      ->capture_default_str();
  command->add_option("--seconds", options.seconds)
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  command->add_option("--rate-hz", options.rate_hz)
      ->check(CLI::Range(0.1, 200.0))
      ->capture_default_str();
  command->add_option("--noise-sigma", options.noise_sigma, "grey levels")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command->add_option("--width-px", options.width_px, "of images 4:3")
      ->check(CLI::Range(64, 1920))
      ->capture_default_str();
  return command;
}

void add_compare(CLI::App& app, CompareOptions& options) {
  auto* command = app.add_subcommand("compare", "compare an exported record with the truth");
  command->add_option("sequence", options.sequence, "folder with the truth")->required();
  command->add_option("result", options.result, "folder that egomod-log export wrote")->required();
  command->add_option("--elapsed-ms", options.elapsed_ms, "that the daemon took")
      ->required()
      ->check(CLI::PositiveNumber);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app("Renders the demo's sequence and compares the daemon's result with the truth.");
    app.require_subcommand(1);
    RenderOptions rendering;
    CompareOptions comparison;
    const CLI::App* render = add_render(app, rendering);
    add_compare(app, comparison);
    CLI11_PARSE(app, argc, argv);
    if (render->parsed()) {
      egomod::demo::render(rendering);
    } else {
      egomod::demo::print_comparison(comparison.sequence, comparison.result,
                                     1e-3 * comparison.elapsed_ms);
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "egomod-demo: {}\n", error.what());
    return 1;
  }
}
