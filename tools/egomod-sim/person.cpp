// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "figure_paints.hpp"
#include "scene_builder.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;
using test_support::Body;
using test_support::Scene;

constexpr double kTexel_m = 0.003;
constexpr double kStride_m = 1.3;  // two steps
constexpr double kHip_m = 0.90;
constexpr double kShoulder_m = 1.42;
constexpr double kThigh_m = 0.45;
constexpr double kShank_m = 0.44;
constexpr double kUpperArm_m = 0.30;
constexpr double kForearm_m = 0.26;
constexpr double kLegSwing_rad = 0.45;
constexpr double kArmSwing_rad = 0.35;
constexpr double kKnee_rad = 0.75;
constexpr double kElbow_rad = 0.30;

constexpr std::size_t kFront = 1;  // of add_box's faces the one that looks ahead

struct Textures {
  std::size_t shirt;
  std::size_t trousers;
  std::size_t skin;
  std::size_t shoe;
  std::size_t face;
  std::size_t hair;
};

Textures paint_clothes(Scene& scene, std::uint32_t seed) {
  const auto square = [&](double side_m, const test_support::Paint& paint) {
    return add_texture(scene, side_m, side_m, kTexel_m, paint);
  };
  const double shirt = 110.0 + 70.0 * test_support::value_noise(0.5, 0.5, seed);
  return {square(0.45, cloth(shirt, seed)),
          square(0.45, cloth(72.0, seed + 11)),
          square(0.12, test_support::plaster(165.0, 20.0, seed + 17)),
          square(0.25, test_support::plaster(40.0, 25.0, seed + 19)),
          add_texture(scene, 0.17, 0.23, 0.002, face(0.17, 0.23, seed + 7)),
          square(0.25, test_support::plaster(55.0, 35.0, seed + 23))};
}

// Half a turn of the phase is a step. The knee bends while the leg comes forward.
struct Gait {
  double thigh_rad;
  double knee_rad;
  double arm_rad;
  double elbow_rad;
};

Gait gait(const Motion& motion, double side, double t_s) {
  const double come_m = way_m(motion, t_s);
  const double phase = 2.0 * M_PI * come_m / kStride_m;
  const double swing = side * std::sin(phase);
  // Standing, both knees are straight: the bend begins with the first step.
  const double begun = std::min(1.0, come_m / (0.25 * kStride_m));
  const double bend = std::max(0.0, side * std::cos(phase)) * begun;
  return {kLegSwing_rad * swing, -kKnee_rad * bend, -kArmSwing_rad * swing,
          kElbow_rad * (1.0 - 0.5 * swing)};
}

// Two segments that hang from a joint, the lower one bent against the upper.
struct Limb {
  Vector3d joint_m;
  double upper_m;
  double (*upper_rad)(const Gait&);
  double (*bend_rad)(const Gait&);
};

Trajectory segment(const Motion& motion, double side, const Limb& limb, bool is_lower) {
  return [T_world_person = on_floor(motion), motion, side, limb, is_lower](double t_s) {
    const Gait now = gait(motion, side, t_s);
    Eigen::Isometry3d T = T_world_person(t_s);
    T.translate(limb.joint_m);
    T.rotate(Eigen::AngleAxisd(limb.upper_rad(now), Vector3d::UnitX()));
    if (is_lower) {
      T.translate(Vector3d(0, limb.upper_m, 0));
      T.rotate(Eigen::AngleAxisd(limb.bend_rad(now), Vector3d::UnitX()));
    }
    return T;
  };
}

Body box_that(const Trajectory& moves, int id, const test_support::Box& box, std::size_t texture) {
  Body body;
  body.id = id;
  add_box(body, box, texture, texture);
  body.T_world_body = moves;
  return body;
}

void push_leg(Scene& scene, int id, const Motion& motion, double side, const Textures& textures) {
  const Limb leg{{0.09 * side, -kHip_m, 0},
                 kThigh_m,
                 [](const Gait& g) { return g.thigh_rad; },
                 [](const Gait& g) { return g.knee_rad; }};
  scene.bodies.push_back(box_that(segment(motion, side, leg, false), id,
                                  {{0, 0.5 * kThigh_m, 0}, {0.15, kThigh_m, 0.17}},
                                  textures.trousers));
  Body shank = box_that(segment(motion, side, leg, true), id,
                        {{0, 0.5 * kShank_m - 0.03, 0}, {0.12, kShank_m, 0.13}}, textures.trousers);
  add_box(shank, {{0, kShank_m - 0.03, 0.05}, {0.095, 0.08, 0.27}}, textures.shoe, textures.shoe);
  scene.bodies.push_back(std::move(shank));
}

void push_arm(Scene& scene, int id, const Motion& motion, double side, const Textures& textures) {
  const Limb arm{{0.255 * side, -kShoulder_m, 0},
                 kUpperArm_m,
                 [](const Gait& g) { return g.arm_rad; },
                 [](const Gait& g) { return g.elbow_rad; }};
  scene.bodies.push_back(box_that(segment(motion, side, arm, false), id,
                                  {{0, 0.5 * kUpperArm_m - 0.02, 0}, {0.10, kUpperArm_m, 0.12}},
                                  textures.shirt));
  Body forearm =
      box_that(segment(motion, side, arm, true), id,
               {{0, 0.5 * kForearm_m - 0.02, 0}, {0.085, kForearm_m, 0.095}}, textures.shirt);
  add_box(forearm, {{0, kForearm_m + 0.05, 0}, {0.07, 0.16, 0.085}}, textures.skin, textures.skin);
  scene.bodies.push_back(std::move(forearm));
}

Body trunk(const Motion& motion, int id, const Textures& textures) {
  Body body = box_that(on_floor(motion), id, {{0, -1.235, 0}, {0.41, 0.43, 0.23}}, textures.shirt);
  add_box(body, {{0, -0.95, 0}, {0.35, 0.17, 0.21}}, textures.trousers, textures.trousers);
  add_box(body, {{0, -1.475, 0}, {0.11, 0.07, 0.11}}, textures.skin, textures.skin);
  const std::size_t head = body.patches.size();
  add_box(body, {{0, -1.615, 0}, {0.16, 0.22, 0.19}}, textures.hair, textures.hair);
  body.patches[head + kFront].texture = textures.face;
  return body;
}

}  // namespace

void add_person(Scene& scene, int id, const Motion& motion, std::uint32_t seed) {
  const Textures textures = paint_clothes(scene, seed);
  scene.bodies.push_back(trunk(motion, id, textures));
  for (const double side : {-1.0, 1.0}) {
    push_leg(scene, id, motion, side, textures);
    push_arm(scene, id, motion, side, textures);
  }
}

}  // namespace egomod::sim
