// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include "gallery.hpp"
#include "recorder.hpp"
#include "serve.hpp"
#include "speed.hpp"
#include "world_file.hpp"

namespace egomod::sim {
namespace {

struct Arguments {
  std::string world;
  std::string folder;
  std::string log;
  std::string gallery;
  std::optional<std::uint32_t> seed;
  std::optional<double> duration_s;
  FolderOptions options;
  ServeOptions serve;
  bool list = false;
  bool speed = false;
};

World chosen_world(const Arguments& arguments) {
  World world = read_world(find_world(arguments.world, world_folder()));
  if (arguments.seed) world.seed = *arguments.seed;
  // Only shorter: the file was checked for its own duration.
  if (arguments.duration_s && (world.is_endless() || *arguments.duration_s < world.duration_s)) {
    world.duration_s = *arguments.duration_s;
  }
  return world;
}

World finite_world(const Arguments& arguments) {
  World world = chosen_world(arguments);
  if (world.is_endless()) throw WorldError(world.name + ": is endless; give --duration SECONDS");
  return world;
}

void record(const Arguments& arguments) {
  Simulator simulator(finite_world(arguments));
  const World& world = simulator.world();
  const RecordingSummary done =
      record(simulator, {arguments.folder, arguments.log, arguments.options});
  fmt::print("{}: {} left and {} right images of {}x{}, {:.1f} pairs/s, on {}\n", world.name,
             done.left_images, done.right_images, world.camera.width_px, world.camera.height_px,
             done.left_images / done.took_s, simulator.device());
}

void run(const Arguments& arguments) {
  if (arguments.list) {
    for (const std::string& name : worlds_in(world_folder())) std::puts(name.c_str());
    return;
  }
  if (!arguments.gallery.empty()) {
    write_gallery(world_folder(), arguments.gallery);
    return;
  }
  if (arguments.world.empty()) throw CLI::ValidationError("which world? --list shows them");
  if (arguments.serve.socket >= 0) {
    Simulator simulator(chosen_world(arguments));
    return serve(simulator, arguments.serve);
  }
  if (arguments.speed) {
    Simulator simulator(finite_world(arguments));
    fmt::print("{}", measure_speed(simulator));
    return;
  }
  if (arguments.folder.empty() && arguments.log.empty()) {
    throw CLI::ValidationError("nothing to write: give --out DIR, --log FILE or both");
  }
  record(arguments);
}

}  // namespace
}  // namespace egomod::sim

int main(int argc, char** argv) {
  CLI::App app("Renders what a stereo rig sees of a world, with exact truth");
  egomod::sim::Arguments arguments;
  app.add_option("WORLD", arguments.world, "Name of a world (--list), or the path of its file");
  app.add_option(
      "--out", arguments.folder,
      "Folder of the KITTI odometry layout, with poses.txt and objects.csv; overwritten");
  app.add_option("--log", arguments.log, "LCM log of calibration, images and truth; overwritten");
  app.add_option("--seed", arguments.seed, "Of textures and noise (default: the world's)");
  app.add_option("--duration", arguments.duration_s, "End earlier, seconds")
      ->check(CLI::PositiveNumber);
  app.add_flag("--depth", arguments.options.depth, "Write depth_0 too: 16-bit PNG, millimetres")
      ->needs("--out");
  app.add_flag("--masks", arguments.options.masks, "Write mask_0 too: 8-bit PNG, object ids")
      ->needs("--out");
  app.add_option("--gallery", arguments.gallery,
                 "PNG with a picture of each installed world; overwritten");
  app.add_flag("--speed", arguments.speed, "Write nothing; tell how fast pairs and truth come");
  auto* serve =
      app.add_option("--serve", arguments.serve.socket,
                     "For egomodd --source sim, which starts this program: the socket to it");
  app.add_flag("--realtime", arguments.serve.realtime,
               "Serve by the wall clock, and leave out what there is no time for")
      ->needs(serve);
  app.add_option("--lcm-url", arguments.serve.lcm_url,
                 "Serve: the bus on which a driven rig gets its commands")
      ->needs(serve);
  app.add_flag("--list", arguments.list, "Print the names of the worlds that are installed");
  try {
    app.parse(argc, argv);
    egomod::sim::run(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "egomod-sim: %s\n", error.what());
    return 1;
  }
  return 0;
}
