// SPDX-License-Identifier: Apache-2.0
#include "world_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "camera_tables.hpp"
#include "drive_file.hpp"
#include "materials.hpp"
#include "table_reader.hpp"
#include "world_check.hpp"

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;

constexpr double kFar_m = 1000.0;
constexpr double kMaxSpeed_mps = 50.0;

void read_profile(TableReader& in, SpeedProfile& p) {
  p.acceleration_mps2 = in.number("acceleration_mps2", 0.0, -20.0, 20.0);
  p.start_s = in.number("start_s", 0.0, 0.0, 1e5);
  p.go_s = in.number("go_s", 0.0, 0.0, 1e5);
  p.pause_s = in.number("pause_s", 0.0, 0.0, 1e5);
  p.ramp_s = in.number("ramp_s", p.ramp_s, 0.0, 100.0);
  if (p.go_s > 0.0 && p.acceleration_mps2 != 0.0) {
    in.fail("acceleration_mps2", "cannot be combined with go_s");
  }
  if (p.pause_s > 0.0 && p.go_s <= 0.0) in.fail("pause_s", "needs go_s");
}

PlanPose read_place(TableReader& in) {
  const auto at = in.numbers("position_m", 2, -kFar_m, kFar_m);
  return {at[0], at[1], degrees(in, "heading_deg", 360.0)};
}

Path read_waypoints(TableReader& in) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& point : in.points("points_m", -kFar_m, kFar_m)) {
    points.emplace_back(point[0], point[1]);
    const std::size_t n = points.size();
    if (n > 1 && (points[n - 1] - points[n - 2]).norm() < 1e-3) {
      in.fail("points_m", fmt::format("points {} and {} are the same", n - 1, n));
    }
  }
  return rounded_path(points, in.number("corner_radius_m", 0.5, 0.01, kFar_m));
}

void read_moving(TableReader& in, std::size_t kind, Motion& motion) {
  constexpr std::size_t kArc = 2;
  constexpr std::size_t kSpin = 3;
  constexpr std::size_t kWaypoints = 4;
  const bool spins = kind == kSpin;
  read_profile(in, motion.profile);
  if (spins && motion.profile.acceleration_mps2 != 0.0) {
    in.fail("acceleration_mps2", "a spin has none");
  }
  motion.profile.speed_mps = spins ? 1.0 : in.number("speed_mps", std::nullopt, 0.0, kMaxSpeed_mps);
  const double turn_radps =
      kind == kArc || spins ? in.number("turn_degps", std::nullopt, -720, 720) * kRadPerDeg : 0.0;
  if (kind == kArc && motion.profile.speed_mps <= 0.0) {
    in.fail("speed_mps", "an arc needs some; to turn in place use kind = \"spin\"");
  }
  motion.spin_radps = spins ? turn_radps : 0.0;
  motion.path = kind == kWaypoints
                    ? read_waypoints(in)
                    : endless_path(read_place(in),
                                   kind == kArc ? turn_radps / motion.profile.speed_mps : 0.0);
}

void read_motion(TableReader& in, Motion& motion) {
  const auto kind = in.choice("kind", {"still", "line", "arc", "spin", "waypoints"}, std::nullopt);
  motion.facing_rad = degrees(in, "facing_deg", 360.0);
  if (kind == 0) {
    motion.path = endless_path(read_place(in), 0.0);
  } else {
    read_moving(in, kind, motion);
  }
}

void read_required_motion(TableReader& in, Motion& motion) {
  if (!in.has("motion")) in.fail("motion", "is missing");
  in.table("motion", [&](TableReader& table) { read_motion(table, motion); });
}

void read_wobble(TableReader& in, Wobble& wobble) {
  wobble.pitch_rad = degrees(in, "pitch_deg", 10.0);
  wobble.roll_rad = degrees(in, "roll_deg", 10.0);
  wobble.bounce_m = in.number("bounce_m", 0.0, 0.0, 0.2);
  wobble.wavelength_m = in.number("wavelength_m", wobble.wavelength_m, 0.01, 100.0);
}

void read_rig_motion(TableReader& in, World& world) {
  Rig& rig = world.rig;
  if (!in.has("driven")) return read_required_motion(in, rig.motion);
  if (in.has("motion")) in.fail("motion", "a rig that is driven has none of its own");
  in.table("driven", [&](TableReader& table) {
    rig.driven = read_drive(table, floor_of(world.shell));
    rig.motion.path = endless_path(rig.driven->start, 0.0);
  });
}

void read_rig(TableReader& in, World& world) {
  Rig& rig = world.rig;
  rig.height_m = in.number("height_m", rig.height_m, 0.05, 10.0);
  rig.pitch_rad = degrees(in, "pitch_deg", 60.0);
  read_rig_motion(in, world);
  in.table("wobble", [&](TableReader& table) { read_wobble(table, rig.wobble); });
  const char* const way = rig.driven ? "driven" : "motion";
  if (const auto fault = fault_of_rig(world)) in.fail(way, *fault);
  if (rig.height_m >= world.shell.height_m) in.fail("height_m", "is above the ceiling");
}

std::string read_material(TableReader& in, const std::string& key, const std::string& fallback) {
  const std::vector<std::string> names = material_names();
  const auto index = static_cast<std::size_t>(std::ranges::find(names, fallback) - names.begin());
  return names[in.choice(key, names, index)];
}

void read_shell(TableReader& in, Shell& shell) {
  shell.kind =
      static_cast<ShellKind>(in.choice("kind", {"room", "corridor", "street"}, std::nullopt));
  const bool street = shell.kind == ShellKind::kStreet;
  if (street)
    shell = {.kind = shell.kind,
             .left = "facade",
             .right = "facade",
             .front = "facade",
             .back = "facade",
             .floor = "road"};
  shell.width_m = in.number("width_m", std::nullopt, 0.5, kFar_m);
  shell.length_m = in.number("length_m", std::nullopt, 0.5, kFar_m);
  shell.height_m = in.number("height_m", street ? 9.0 : 2.8, 0.5, 100.0);
  shell.rear_m = in.number("rear_m", shell.rear_m, 0.0, kFar_m);
  if (shell.rear_m > shell.length_m) in.fail("rear_m", "is more than length_m");
  for (auto [key, field] : {std::pair{"left", &Shell::left}, std::pair{"right", &Shell::right},
                            std::pair{"front", &Shell::front}, std::pair{"back", &Shell::back},
                            std::pair{"floor", &Shell::floor}}) {
    shell.*field = read_material(in, key, shell.*field);
  }
  if (!street) shell.ceiling = read_material(in, "ceiling", shell.ceiling);
}

void read_poster(TableReader& in, World& world) {
  const Shell& shell = world.shell;
  Poster poster;
  poster.wall = static_cast<Wall>(in.choice("wall", {"left", "right", "front", "back"}, {}));
  poster.along_m = in.number("along_m", std::nullopt, -kFar_m, kFar_m);
  poster.height_m = in.number("height_m", poster.height_m, 0.0, kFar_m);
  const auto size = in.numbers("size_m", 2, 0.05, 20.0, {poster.size_m.x(), poster.size_m.y()});
  poster.size_m = {size[0], size[1]};
  const Eigen::Vector2d half = 0.5 * poster.size_m;
  const bool side = poster.wall == Wall::kLeft || poster.wall == Wall::kRight;
  const double from = side ? -shell.rear_m : -0.5 * shell.width_m;
  const double to = side ? shell.length_m - shell.rear_m : 0.5 * shell.width_m;
  if (poster.along_m - half.x() < from || poster.along_m + half.x() > to) {
    in.fail("along_m", fmt::format("it hangs beyond the wall, which is {} to {} m", from, to));
  }
  if (poster.height_m - half.y() < 0.0 || poster.height_m + half.y() > shell.height_m) {
    in.fail("height_m",
            fmt::format("it hangs beyond the wall, which is 0 to {} m", shell.height_m));
  }
  world.posters.push_back(poster);
}

void read_box(TableReader& in, const World& world, Thing& thing) {
  const auto size = in.numbers("size_m", 3, 0.01, 100.0);
  thing.size_m = {size[0], size[1], size[2]};
  thing.lift_m = in.number("lift_m", 0.0, 0.0, 100.0);
  thing.material = read_material(in, "material", thing.material);
  if (thing.lift_m + thing.size_m.y() > world.shell.height_m) {
    in.fail("size_m", "it is higher than the world");
  }
}

void read_furniture(TableReader& in, World& world) {
  Thing thing;
  read_box(in, world, thing);
  thing.motion.path = endless_path(read_place(in), 0.0);
  if (const auto fault = fault_of_thing(world, thing)) in.fail("position_m", *fault);
  world.things.push_back(thing);
}

void read_object(TableReader& in, World& world, int id) {
  Thing thing;
  thing.id = id;
  thing.kind =
      static_cast<ThingKind>(in.choice("kind", {"box", "pioneer", "person", "car"}, std::nullopt));
  if (thing.kind == ThingKind::kBox) read_box(in, world, thing);
  read_required_motion(in, thing.motion);
  if (const auto fault = fault_of_thing(world, thing)) in.fail("motion", *fault);
  world.things.push_back(thing);
}

constexpr int kMaxObjects = 200;

World read(TableReader& in) {
  World world;
  world.duration_s = in.number("duration_s", std::nullopt, 0.0, 1e5);
  world.seed = static_cast<std::uint32_t>(in.integer("seed", 1, 0, 1'000'000'000));
  for (const char* key : {"shell", "rig", "camera"}) {
    if (!in.has(key)) in.fail(key, "is missing");
  }
  in.table("camera", [&](TableReader& table) { read_camera(table, world); });
  in.table("realism", [&](TableReader& table) { read_realism(table, world); });
  in.table("timing", [&](TableReader& table) { read_timing(table, world); });
  in.table("calibration_error", [&](TableReader& table) { read_calibration_error(table, world); });
  in.table("shell", [&](TableReader& table) { read_shell(table, world.shell); });
  in.table("rig", [&](TableReader& table) { read_rig(table, world); });
  in.tables("poster", [&](TableReader& table) { read_poster(table, world); });
  in.tables("furniture", [&](TableReader& table) { read_furniture(table, world); });
  int id = 0;
  in.tables("object", [&](TableReader& table) {
    if (++id > kMaxObjects) table.fail("kind", fmt::format("more than {} objects", kMaxObjects));
    read_object(table, world, id);
  });
  if (world.is_endless() && !world.rig.driven) {
    in.fail("duration_s", "only a world whose rig is driven can be endless");
  }
  in.finish();
  return world;
}

}  // namespace

World read_world(const fs::path& file, KeyCatalogue* catalogue) {
  if (!fs::is_regular_file(file)) throw WorldError(file.string() + ": there is no such file");
  toml::table table;
  try {
    table = toml::parse_file(file.string());
  } catch (const toml::parse_error& error) {
    throw WorldError(
        fmt::format("{}:{}: {}", file.string(), error.source().begin.line, error.description()));
  }
  TableReader reader(table, file.string(), "", catalogue);
  World world = read(reader);
  world.name = file.stem();
  return world;
}

std::vector<std::string> worlds_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

fs::path find_world(const std::string& name, const fs::path& folder) {
  if (name.find('/') != std::string::npos || name.ends_with(".toml")) return name;
  fs::path file = folder / (name + ".toml");
  if (fs::exists(file)) return file;
  throw WorldError(fmt::format("{}: no such world in {}; there are: {}; or give a file's path",
                               name, folder.string(), fmt::join(worlds_in(folder), ", ")));
}

fs::path world_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "share" / "egomod" / "worlds";
}

}  // namespace egomod::sim
