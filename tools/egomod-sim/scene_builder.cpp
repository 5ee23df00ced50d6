// SPDX-License-Identifier: Apache-2.0
#include "scene_builder.hpp"

#include <array>
#include <cmath>

#include "materials.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;
using test_support::Body;
using test_support::Scene;

constexpr double kFineTexel_m = 0.004;
constexpr double kMaxTexels = 3e6;  // one surface; more only costs memory bandwidth
constexpr double kNarrow_m = 4.0;   // side walls this close are seen flat
constexpr double kPosterGap_m = 0.006;

double texel_m(double width_m, double height_m) {
  return std::max(kFineTexel_m, std::sqrt(width_m * height_m / kMaxTexels));
}

// Numbers surfaces, so that each one is painted with a seed of its own.
class Painter {
 public:
  Painter(Scene& scene, std::uint32_t seed) : scene_(scene), seed_(seed * 1009U) {}
  std::size_t surface(const std::string& name, double width_m, double height_m) {
    seed_ += 20;
    return add_texture(scene_, width_m, height_m, texel_m(width_m, height_m),
                       material(name, width_m, height_m, seed_));
  }

 private:
  Scene& scene_;
  std::uint32_t seed_;
};

void add_shell(const Shell& s, Painter& painter, Body& body) {
  const double x = 0.5 * s.width_m;
  const double h = s.height_m;
  const double near_m = -s.rear_m;
  const double far_m = s.length_m - s.rear_m;
  const Vector3d across(s.width_m, 0, 0);
  const Vector3d down(0, h, 0);
  const Vector3d ahead(0, 0, s.length_m);
  const auto wall = [&](const std::string& name, double width_m, const Vector3d& corner,
                        const Vector3d& along, double light) {
    body.patches.push_back({corner, along, down, painter.surface(name, width_m, h), light,
                            s.width_m < kNarrow_m && along.x() == 0.0});
  };
  wall(s.left, s.length_m, {-x, -h, near_m}, ahead, 0.90);
  wall(s.right, s.length_m, {x, -h, far_m}, -ahead, 1.0);
  wall(s.front, s.width_m, {-x, -h, far_m}, across, 0.95);
  wall(s.back, s.width_m, {x, -h, near_m}, -across, 0.80);
  body.patches.push_back({{-x, 0, near_m},
                          across,
                          ahead,
                          painter.surface(s.floor, s.width_m, s.length_m),
                          0.95,
                          true});
  if (s.kind == ShellKind::kStreet) return;
  body.patches.push_back(
      {{-x, -h, near_m}, across, ahead, painter.surface(s.ceiling, s.width_m, s.length_m), 1.0});
}

void add_poster(const Shell& s, const Poster& poster, Painter& painter, Body& body) {
  const double w = poster.size_m.x();
  const double top = -poster.height_m - 0.5 * poster.size_m.y();
  const double x = 0.5 * s.width_m - kPosterGap_m;
  const double from = poster.along_m - 0.5 * w;
  const double to = poster.along_m + 0.5 * w;
  const double far_m = s.length_m - s.rear_m - kPosterGap_m;
  const std::array<std::pair<Vector3d, Vector3d>, 4> corner_and_edge{{
      {{-x, top, from}, {0, 0, w}},
      {{x, top, to}, {0, 0, -w}},
      {{from, top, far_m}, {w, 0, 0}},
      {{to, top, -s.rear_m + kPosterGap_m}, {-w, 0, 0}},
  }};
  const auto& [corner, edge] = corner_and_edge[static_cast<std::size_t>(poster.wall)];
  body.patches.push_back({corner,
                          edge,
                          {0, poster.size_m.y(), 0},
                          painter.surface("poster", w, poster.size_m.y()),
                          0.97});
}

Body box_of(const Thing& thing, Painter& painter) {
  Body body;
  body.id = thing.id;
  const Vector3d& size = thing.size_m;
  const auto front = painter.surface(thing.material, size.x(), size.y());
  const auto side = painter.surface(thing.material, size.z(), size.y());
  add_box(body, {{0, -thing.lift_m - 0.5 * size.y(), 0}, size}, front, side);
  return body;
}

void add_thing(const Thing& thing, std::uint32_t seed, Painter& painter, BuiltScene& built) {
  const Trajectory T_world_thing = on_floor(thing.motion);
  Scene& scene = built.scene;
  if (thing.kind == ThingKind::kPerson) {
    add_person(scene, thing.id, thing.motion, seed);
  } else if (thing.kind == ThingKind::kCar) {
    add_car(scene, thing.id, T_world_thing, seed);
  } else {
    Body body = thing.kind == ThingKind::kBox ? box_of(thing, painter)
                                              : test_support::robot(scene, thing.id, seed);
    body.T_world_body = T_world_thing;
    scene.bodies.push_back(std::move(body));
  }
  if (thing.id == 0) return;
  const Vector3d centre(0, -thing.lift_m - 0.5 * size_m(thing).y(), 0);
  built.objects.push_back({thing.id, to_string(thing.kind), centre, size_m(thing), T_world_thing});
}

// Three incommensurable waves in each direction; at the start of the way the rig stands level.
double wave(double way_m, double wavelength_m, double phase) {
  const double k = 2.0 * M_PI / wavelength_m;
  const auto ripple = [&](double scale, double weight) {
    return weight * (std::sin(k * way_m / scale + phase * scale) - std::sin(phase * scale));
  };
  return ripple(1.0, 0.5) + ripple(1.618, 0.3) + ripple(2.414, 0.2);
}

Trajectory rig_trajectory(const Rig& rig) {
  return [rig](double t_s) {
    const PlanPose at = pose_at(rig.motion, t_s);
    return T_world_camera(rig, at, way_m(rig.motion, t_s));
  };
}

}  // namespace

Eigen::Isometry3d T_world_camera(const Rig& rig, const PlanPose& at, double way_m) {
  const Wobble& w = rig.wobble;
  const double pitch = rig.pitch_rad + w.pitch_rad * wave(way_m, w.wavelength_m, 0.3);
  const double roll = w.roll_rad * wave(way_m, w.wavelength_m, 1.9);
  const double bounce = w.bounce_m * wave(way_m, w.wavelength_m, 4.1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Vector3d(at.x_m, -rig.height_m - bounce, at.z_m);
  T.linear() =
      (Eigen::AngleAxisd(at.heading_rad, Vector3d::UnitY()) *
       Eigen::AngleAxisd(-pitch, Vector3d::UnitX()) * Eigen::AngleAxisd(roll, Vector3d::UnitZ()))
          .toRotationMatrix();
  return T;
}

Trajectory on_floor(const Motion& motion) {
  return [motion](double t_s) {
    const PlanPose at = pose_at(motion, t_s);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Vector3d(at.x_m, 0, at.z_m);
    T.linear() = Eigen::AngleAxisd(at.heading_rad, Vector3d::UnitY()).toRotationMatrix();
    return T;
  };
}

BuiltScene build_scene(const World& world) {
  BuiltScene built;
  Painter painter(built.scene, world.seed);
  Body shell;
  add_shell(world.shell, painter, shell);
  for (const Poster& poster : world.posters) add_poster(world.shell, poster, painter, shell);
  built.scene.bodies.push_back(std::move(shell));
  std::uint32_t seed = world.seed * 7919U;
  for (const Thing& thing : world.things) add_thing(thing, seed += 31, painter, built);
  built.scene.T_world_camera = rig_trajectory(world.rig);
  return built;
}

}  // namespace egomod::sim
