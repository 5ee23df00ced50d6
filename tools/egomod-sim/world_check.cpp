// SPDX-License-Identifier: Apache-2.0
#include "world_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace egomod::sim {
namespace {

using Eigen::Vector2d;

constexpr double kStep_s = 0.05;
constexpr double kRigSide_m = 0.2;
constexpr double kCheckedOfEndless_s = 3600.0;

// Something upright on the floor: a rectangle that moves.
struct Footprint {
  const Motion& motion;
  Vector2d half_m;  // across, along
  double bottom_m;
  double top_m;
};

Footprint footprint_of(const Thing& thing) {
  const Eigen::Vector3d size = size_m(thing);
  return {thing.motion, {0.5 * size.x(), 0.5 * size.z()}, thing.lift_m, thing.lift_m + size.y()};
}

Footprint footprint_of(const Rig& rig) {
  return {rig.motion, Vector2d::Constant(0.5 * kRigSide_m), 0.0, rig.height_m};
}

// A rectangle at an instant: (x, z) of its middle, and its half sides as vectors.
struct Rectangle {
  Vector2d middle_m;
  std::array<Vector2d, 2> halves_m;

  [[nodiscard]] double reach_m(const Vector2d& direction) const {
    return std::abs(halves_m[0].dot(direction)) + std::abs(halves_m[1].dot(direction));
  }
};

Rectangle rectangle_at(const Footprint& footprint, double t_s) {
  const PlanPose at = pose_at(footprint.motion, t_s);
  const Vector2d along(std::sin(at.heading_rad), std::cos(at.heading_rad));
  const Vector2d across(along.y(), -along.x());
  return {{at.x_m, at.z_m}, {footprint.half_m.x() * across, footprint.half_m.y() * along}};
}

// No line separates them that is parallel to a side of either.
bool overlap(const Rectangle& a, const Rectangle& b) {
  for (const Rectangle* rectangle : {&a, &b}) {
    for (const Vector2d& half : rectangle->halves_m) {
      const Vector2d direction = half.normalized();
      const double apart = std::abs((a.middle_m - b.middle_m).dot(direction));
      if (apart >= a.reach_m(direction) + b.reach_m(direction)) return false;
    }
  }
  return true;
}

bool is_on_floor(const Shell& s, const Rectangle& r) {
  const double x = r.reach_m(Vector2d::UnitX());
  const double z = r.reach_m(Vector2d::UnitY());
  return std::abs(r.middle_m.x()) + x <= 0.5 * s.width_m && r.middle_m.y() - z >= -s.rear_m &&
         r.middle_m.y() + z <= s.length_m - s.rear_m;
}

double checked_s(const World& world) {
  return world.is_endless() ? kCheckedOfEndless_s : world.duration_s;
}

std::optional<std::string> leaves_floor(const World& world, const Footprint& footprint) {
  const Shell& s = world.shell;
  for (double t = 0.0; t < checked_s(world); t += kStep_s) {
    const Rectangle at = rectangle_at(footprint, t);
    if (is_on_floor(s, at)) continue;
    return fmt::format(
        "at {:.2f} s it is outside the world: x {:.2f}, z {:.2f} m, {:.2f} m across and {:.2f} m "
        "along; the floor reaches from x {:.2f} to {:.2f} and z {:.2f} to {:.2f}",
        t, at.middle_m.x(), at.middle_m.y(), 2.0 * footprint.half_m.x(), 2.0 * footprint.half_m.y(),
        -0.5 * s.width_m, 0.5 * s.width_m, -s.rear_m, s.length_m - s.rear_m);
  }
  return std::nullopt;
}

std::optional<std::string> runs_into(const World& world, const Footprint& one,
                                     const Footprint& other, const std::string& name) {
  if (one.bottom_m >= other.top_m || other.bottom_m >= one.top_m) return std::nullopt;
  for (double t = 0.0; t < checked_s(world); t += kStep_s) {
    const Rectangle at = rectangle_at(one, t);
    if (!overlap(at, rectangle_at(other, t))) continue;
    return fmt::format("at {:.2f} s, at x {:.2f}, z {:.2f} m, it runs into {}", t, at.middle_m.x(),
                       at.middle_m.y(), name);
  }
  return std::nullopt;
}

std::optional<std::string> runs_into_things(const World& world, const Footprint& one) {
  int furniture = 0;
  for (const Thing& thing : world.things) {
    const std::string name = thing.id > 0 ? fmt::format("object[{}]", thing.id)
                                          : fmt::format("furniture[{}]", ++furniture);
    if (auto fault = runs_into(world, one, footprint_of(thing), name)) return fault;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> fault_of_rig(const World& world) {
  const Footprint rig = footprint_of(world.rig);
  if (auto fault = leaves_floor(world, rig)) return fault;
  return runs_into_things(world, rig);
}

std::optional<std::string> fault_of_thing(const World& world, const Thing& thing) {
  const Footprint footprint = footprint_of(thing);
  if (auto fault = leaves_floor(world, footprint)) return fault;
  // Nobody knows yet where a driven rig will be.
  if (!world.rig.driven) {
    if (auto fault = runs_into(world, footprint, footprint_of(world.rig), "the rig")) return fault;
  }
  if (thing.id == 0) return std::nullopt;  // furniture may be built of several pieces
  return runs_into_things(world, footprint);
}

}  // namespace egomod::sim
