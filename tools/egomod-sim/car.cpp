// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "figure_paints.hpp"
#include "scene_builder.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;
using test_support::Body;
using test_support::Scene;

constexpr double kTexel_m = 0.006;
const Vector3d kLower(1.72, 0.58, 4.20);
constexpr double kLowerMiddle_m = -0.57;
const Vector3d kCabin(1.48, 0.56, 1.90);
constexpr double kCabinTop_m = -1.43;
constexpr double kWheelRadius_m = 0.31;
constexpr double kWheelWidth_m = 0.20;

// Where add_box puts the faces of its box.
enum Face : std::size_t { kRear, kFront, kLeft, kRight, kTop };

struct Textures {
  std::size_t rear, front, side, hood, pane, windows, roof, tyre;
};

Textures paint_car(Scene& scene, std::uint32_t seed) {
  const auto painted = [&](double width_m, double height_m, const test_support::Paint& paint) {
    return add_texture(scene, width_m, height_m, kTexel_m, paint);
  };
  const auto [w, h, l] = std::array{kLower.x(), kLower.y(), kLower.z()};
  return {.rear = painted(w, h, car_end(w, h, false, seed)),
          .front = painted(w, h, car_end(w, h, true, seed)),
          .side = painted(l, h, car_side(l, h, kWheelRadius_m, seed)),
          .hood = painted(w, l, car_paint(seed)),
          .pane = painted(kCabin.x(), 0.7, car_pane(kCabin.x(), 0.7, 1, seed)),
          .windows = painted(kCabin.z(), kCabin.y(), car_pane(kCabin.z(), kCabin.y(), 2, seed)),
          .roof = painted(kCabin.x(), kCabin.z(), car_paint(seed + 5)),
          .tyre = painted(0.6, 0.6, test_support::plaster(35.0, 25.0, seed + 3))};
}

void add_lower(Body& car, const Textures& textures) {
  const std::size_t first = car.patches.size();
  add_box(car, {{0, kLowerMiddle_m, 0}, kLower}, textures.rear, textures.side);
  car.patches[first + kFront].texture = textures.front;
  car.patches[first + kTop].texture = textures.hood;
}

// A box, with slanting panes before and behind it and a step under each.
void add_cabin(Body& car, const Textures& textures) {
  constexpr double kBack_m = -0.25;
  const double bottom_m = kCabinTop_m + kCabin.y();
  const auto box = [&](double z_m, double top_m, double length_m) {
    const std::size_t first = car.patches.size();
    add_box(car, {{0, 0.5 * (top_m + bottom_m), z_m}, {kCabin.x(), bottom_m - top_m, length_m}},
            textures.pane, textures.windows);
    car.patches[first + kTop].texture = textures.roof;
  };
  box(kBack_m, kCabinTop_m, kCabin.z());
  for (const double towards : {1.0, -1.0}) {
    const double slant_m = towards > 0.0 ? 0.62 : 0.40;
    const double edge_m = kBack_m + towards * 0.5 * kCabin.z();
    box(edge_m + towards * 0.25 * slant_m, kCabinTop_m + 0.55 * kCabin.y(), 0.5 * slant_m);
    car.patches.push_back({{0.5 * kCabin.x() * towards, kCabinTop_m, edge_m},
                           {-kCabin.x() * towards, 0, 0},
                           {0, kCabin.y(), towards * slant_m},
                           textures.pane,
                           0.95});
  }
}

// Two squares, turned against each other, are nearly round.
void add_wheel(Body& car, const Vector3d& middle_m, std::size_t tyre) {
  const double side_m = 2.0 * kWheelRadius_m / std::sqrt(2.0);
  for (const double angle_rad : {0.0, 0.25 * M_PI}) {
    Body wheel;
    add_box(wheel, {Vector3d::Zero(), {kWheelWidth_m, side_m, side_m}}, tyre, tyre);
    const Eigen::AngleAxisd turn(angle_rad, Vector3d::UnitX());
    for (test_support::Patch patch : wheel.patches) {
      patch.corner_m = middle_m + turn * patch.corner_m;
      patch.edge_s_m = turn * patch.edge_s_m;
      patch.edge_t_m = turn * patch.edge_t_m;
      car.patches.push_back(patch);
    }
  }
}

}  // namespace

void add_car(Scene& scene, int id, const Trajectory& T_world_car, std::uint32_t seed) {
  const Textures textures = paint_car(scene, seed);
  Body car;
  car.id = id;
  add_lower(car, textures);
  add_cabin(car, textures);
  for (const double x : {-0.77, 0.77}) {
    for (const double z : {-kAxle_m, kAxle_m}) {
      add_wheel(car, {x, -kWheelRadius_m, z}, textures.tyre);
    }
  }
  car.T_world_body = T_world_car;
  scene.bodies.push_back(std::move(car));
}

}  // namespace egomod::sim
