// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "materials.hpp"
#include "scene_builder.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;
using test_support::Body;
using test_support::Scene;

constexpr double kTexel_m = 0.003;
constexpr double kCarTexel_m = 0.006;
constexpr double kStride_m = 1.3;  // two steps
constexpr double kHip_m = 0.86;
constexpr double kShoulder_m = 1.42;
constexpr double kLegSwing_rad = 0.42;
constexpr double kArmSwing_rad = 0.35;

// A limb hangs from its joint and swings with the way walked.
struct Limb {
  Vector3d joint_m;
  Vector3d size_m;
  double swing_rad;
};

Trajectory swinging(const Motion& motion, const Limb& limb) {
  return [T_world_person = on_floor(motion), motion, limb](double t_s) {
    const double phase = 2.0 * M_PI * distance_m(motion.profile, t_s) / kStride_m;
    Eigen::Isometry3d T = T_world_person(t_s);
    T.translate(limb.joint_m);
    T.rotate(Eigen::AngleAxisd(limb.swing_rad * std::sin(phase), Vector3d::UnitX()));
    return T;
  };
}

std::size_t clothing(Scene& scene, const Vector3d& size_m, double base, std::uint32_t seed) {
  return add_texture(scene, std::max(size_m.x(), size_m.z()), size_m.y(), kTexel_m,
                     cloth(base, seed));
}

void push_limb(Scene& scene, int id, const Motion& motion, const Limb& limb, std::size_t texture) {
  Body body;
  body.id = id;
  add_box(body, {{0, 0.5 * limb.size_m.y(), 0}, limb.size_m}, texture, texture);
  body.T_world_body = swinging(motion, limb);
  scene.bodies.push_back(std::move(body));
}

void push_trunk(Scene& scene, int id, const Motion& motion, double shirt, std::uint32_t seed) {
  const Vector3d trunk(0.42, 0.62, 0.24);
  const Vector3d head(0.17, 0.24, 0.20);
  Body body;
  body.id = id;
  const auto cloth_texture = clothing(scene, trunk, shirt, seed);
  const auto face_texture =
      add_texture(scene, head.x(), head.y(), kTexel_m, face(head.x(), head.y(), seed + 7));
  add_box(body, {{0, -1.15, 0}, trunk}, cloth_texture, cloth_texture);
  add_box(body, {{0, -1.60, 0}, head}, face_texture, face_texture);
  body.T_world_body = on_floor(motion);
  scene.bodies.push_back(std::move(body));
}

}  // namespace

void add_person(Scene& scene, int id, const Motion& motion, std::uint32_t seed) {
  const Vector3d leg(0.15, kHip_m, 0.17);
  const Vector3d arm(0.10, 0.60, 0.11);
  const double shirt = 95.0 + 60.0 * test_support::value_noise(0.5, 0.5, seed);
  push_trunk(scene, id, motion, shirt, seed);
  const auto trousers = clothing(scene, leg, 70.0, seed + 11);
  const auto sleeve = clothing(scene, arm, shirt - 10.0, seed + 13);
  for (const double side : {-1.0, 1.0}) {
    push_limb(scene, id, motion, {{0.10 * side, -kHip_m, 0}, leg, kLegSwing_rad * side}, trousers);
    push_limb(scene, id, motion, {{0.27 * side, -kShoulder_m, 0}, arm, -kArmSwing_rad * side},
              sleeve);
  }
}

void add_car(Scene& scene, int id, const Trajectory& T_world_car, std::uint32_t seed) {
  const Vector3d body_size(1.72, 0.68, 4.20);
  const Vector3d cabin(1.50, 0.54, 2.10);
  const auto painted = [&](double width_m, double height_m, const test_support::Paint& paint) {
    return add_texture(scene, width_m, height_m, kCarTexel_m, paint);
  };
  Body car;
  car.id = id;
  const auto end =
      painted(body_size.x(), body_size.y(), car_body(body_size.x(), body_size.y(), seed));
  const auto side =
      painted(body_size.z(), body_size.y(), car_body(body_size.z(), body_size.y(), seed));
  const auto screen = painted(cabin.x(), cabin.y(), car_cabin(cabin.x(), cabin.y(), seed + 1));
  const auto windows = painted(cabin.z(), cabin.y(), car_cabin(cabin.z(), cabin.y(), seed + 2));
  const auto tyre = painted(0.6, 0.6, test_support::plaster(35.0, 25.0, seed + 3));
  add_box(car, {{0, -0.58, 0}, body_size}, end, side);
  add_box(car, {{0, -1.18, -0.15}, cabin}, screen, windows);
  for (const double x : {-0.78, 0.78}) {
    for (const double z : {-1.30, 1.30}) {
      add_box(car, {{x, -0.30, z}, {0.20, 0.60, 0.60}}, tyre, tyre);
    }
  }
  car.T_world_body = T_world_car;
  scene.bodies.push_back(std::move(car));
}

}  // namespace egomod::sim
