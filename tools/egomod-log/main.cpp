// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include "commands.hpp"

int main(int argc, char** argv) {
  CLI::App app("Makes, reads and shows LCM logs of egomod");
  app.require_subcommand(1);
  std::string log;
  std::string folder;
  std::string images;
  std::optional<int> jpeg_quality;

  auto* const imported = app.add_subcommand("import", "Write a folder of stereo pairs into a log");
  imported->add_option("DIR", folder, "Folder of the KITTI odometry or EuRoC layout")->required();
  imported->add_option("LOG", log, "Log to write; overwritten")->required();
  imported
      ->add_option("--jpeg", jpeg_quality, "Compress the images, quality 1 to 100 (default: raw)")
      ->check(CLI::Range(1, 100));
  imported->callback([&] { egomod::log::import_sequence(folder, log, jpeg_quality); });

  auto* const exported = app.add_subcommand(
      "export", "Write poses.txt, times.txt, objects.csv and, if there is timing, timing.csv");
  exported->add_option("LOG", log, "A record of egomodd")->required();
  exported->add_option("DIR", folder, "Folder to write into; made if needed")->required();
  exported->callback([&] { egomod::log::export_log(log, folder); });

  auto* const info = app.add_subcommand("info", "Print channels, types, counts, rates, time span");
  info->add_option("LOG", log, "Any LCM log")->required();
  info->callback([&] { egomod::log::print_info(log); });

  auto* const draw = app.add_subcommand("draw", "Draw tracks and objects onto the left images");
  draw->add_option("LOG", log, "A record of egomodd")->required();
  draw->add_option("DIR", folder, "Folder to write PNG files into; made if needed")->required();
  draw->add_option("--images", images, "Folder of the sequence, when the log holds no images");
  draw->callback([&] { egomod::log::draw_log(log, folder, images); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "egomod-log: %s\n", error.what());
    return 1;
  }
  return 0;
}
