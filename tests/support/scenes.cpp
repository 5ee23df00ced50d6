// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"

#include <cmath>

namespace egomod::test_support {
namespace {

constexpr double kHalfWidth_m = 3.5;
constexpr double kRear_m = -1.0;
constexpr double kDepth_m = 12.0;
constexpr double kHeight_m = 2.8;
constexpr double kCeiling_m = kFloor_m - kHeight_m;
constexpr double kWallTexel_m = 0.008;
constexpr double kFineTexel_m = 0.004;
constexpr double kPosterGap_m = 0.004;

using Eigen::Vector3d;

void add_walls(Scene& scene, Body& room, std::uint32_t seed) {
  const auto texture = [&](double width_m, double height_m, const Paint& paint) {
    return add_texture(scene, width_m, height_m, kWallTexel_m, paint);
  };
  const auto brick = texture(2 * kHalfWidth_m, kHeight_m, bricks(seed));
  const auto left = texture(kDepth_m, kHeight_m, plaster(150, 75, seed + 20));
  const auto right = texture(kDepth_m, kHeight_m, plaster(160, 75, seed + 40));
  const auto tiles = texture(2 * kHalfWidth_m, kDepth_m, floor_tiles(0.40, seed + 60));
  const auto ceiling =
      add_texture(scene, 2 * kHalfWidth_m, kDepth_m, 2 * kWallTexel_m, plaster(195, 35, seed + 80));
  const Vector3d across(2 * kHalfWidth_m, 0, 0);
  const Vector3d down(0, kHeight_m, 0);
  const Vector3d ahead(0, 0, kDepth_m);
  const double far_m = kRear_m + kDepth_m;
  room.patches = {
      {{-kHalfWidth_m, kCeiling_m, far_m}, across, down, brick, 0.95},
      {{kHalfWidth_m, kCeiling_m, kRear_m}, -across, down, brick, 0.80},
      {{-kHalfWidth_m, kCeiling_m, kRear_m}, ahead, down, left, 0.90},
      {{kHalfWidth_m, kCeiling_m, far_m}, -ahead, down, right, 1.0},
      {{-kHalfWidth_m, kFloor_m, kRear_m}, across, ahead, tiles, 0.95},
      {{-kHalfWidth_m, kCeiling_m, kRear_m}, across, ahead, ceiling, 1.0},
  };
}

// Pictures on the far wall and along both sides.
void add_posters(Scene& scene, Body& room, std::uint32_t seed) {
  constexpr double kWidth_m = 0.9;
  constexpr double kHigh_m = 1.2;
  const Vector3d down(0, kHigh_m, 0);
  const auto texture = [&](std::uint32_t i) {
    return add_texture(scene, kWidth_m, kHigh_m, kFineTexel_m,
                       poster(kWidth_m, kHigh_m, seed + 100 + i));
  };
  std::uint32_t i = 0;
  const double far_m = kRear_m + kDepth_m - kPosterGap_m;
  for (const double x : {-2.6, -0.5, 1.7}) {
    room.patches.push_back({{x, -1.5, far_m}, {kWidth_m, 0, 0}, down, texture(i++), 1.0});
  }
  for (const double z : {1.2, 4.0, 6.6, 9.0}) {
    room.patches.push_back({{-kHalfWidth_m + kPosterGap_m, -1.35 + 0.05 * z, z},
                            {0, 0, kWidth_m},
                            down,
                            texture(i++),
                            0.95});
    room.patches.push_back({{kHalfWidth_m - kPosterGap_m, -1.30 + 0.04 * z, z + 1.6},
                            {0, 0, -kWidth_m},
                            down,
                            texture(i++),
                            1.0});
  }
}

void add_furniture(Scene& scene, Body& room, std::uint32_t seed) {
  const auto box_on_floor = [&](double x, double z, Vector3d size_m, std::uint32_t kind) {
    const auto front = add_texture(scene, size_m.x(), size_m.y(), kFineTexel_m,
                                   carton(size_m.x(), size_m.y(), seed + 200 + kind));
    const auto side = add_texture(scene, size_m.z(), size_m.y(), kFineTexel_m,
                                  carton(size_m.z(), size_m.y(), seed + 300 + kind));
    add_box(room, {{x, kFloor_m - 0.5 * size_m.y(), z}, size_m}, front, side);
  };
  box_on_floor(-2.7, 3.2, {0.7, 0.9, 0.6}, 1);
  box_on_floor(-2.9, 5.6, {0.8, 1.5, 0.7}, 2);
  box_on_floor(2.8, 4.6, {0.7, 0.7, 0.8}, 3);
  box_on_floor(2.6, 7.4, {0.9, 1.7, 0.5}, 4);
  box_on_floor(-1.6, 9.8, {1.0, 0.8, 0.5}, 5);
  box_on_floor(1.2, 10.2, {0.6, 0.6, 0.6}, 6);
}

Eigen::Isometry3d pose(const Vector3d& position_m, double yaw_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()).toRotationMatrix();
  T.translation() = position_m;
  return T;
}

void push_robot(Scene& scene, int id, const Trajectory& T_world_body) {
  Body body = robot(scene, id, static_cast<std::uint32_t>(id));
  body.T_world_body = T_world_body;
  scene.bodies.push_back(std::move(body));
}

// Level drive along z that sways sideways and looks where it goes.
Trajectory s_curve(double speed_mps, double sway_m, double period_s) {
  return [=](double t_s) {
    const double phase = 2.0 * M_PI * t_s / period_s;
    const double slope = sway_m * 2.0 * M_PI / period_s * std::sin(phase) / speed_mps;
    return pose({sway_m * (1.0 - std::cos(phase)), 0, speed_mps * t_s}, std::atan(slope));
  };
}

}  // namespace

StereoCamera kinect_pair(int width_px) {
  const double scale = width_px / 640.0;
  const auto scaled_centre = [&](double c) { return (c + 0.5) * scale - 0.5; };
  return {.fx_px = 525.0 * scale,
          .fy_px = 525.0 * scale,
          .cx_px = scaled_centre(319.5),
          .cy_px = scaled_centre(239.5),
          .baseline_m = 0.375,
          .width_px = width_px,
          .height_px = static_cast<int>(std::lround(480.0 * scale))};
}

std::size_t add_texture(Scene& scene, double width_m, double height_m, double texel_m,
                        const Paint& paint) {
  scene.textures.emplace_back(width_m, height_m, texel_m, paint);
  return scene.textures.size() - 1;
}

void add_box(Body& body, const Box& box, std::size_t front, std::size_t side) {
  const Vector3d h = 0.5 * box.size_m;
  const Vector3d x(box.size_m.x(), 0, 0);
  const Vector3d y(0, box.size_m.y(), 0);
  const Vector3d z(0, 0, box.size_m.z());
  const auto corner = [&](double sx, double sy, double sz) {
    return Vector3d(box.centre_m + Vector3d(sx * h.x(), sy * h.y(), sz * h.z()));
  };
  body.patches.push_back({corner(-1, -1, -1), x, y, front, 0.95});
  body.patches.push_back({corner(1, -1, 1), -x, y, front, 0.85});
  body.patches.push_back({corner(-1, -1, 1), -z, y, side, 0.75});
  body.patches.push_back({corner(1, -1, -1), z, y, side, 0.85});
  body.patches.push_back({corner(-1, -1, 1), x, -z, side, 1.1});
  body.patches.push_back({corner(-1, 1, -1), x, z, side, 0.4});
}

Scene furnished_room(std::uint32_t seed) {
  Scene scene;
  Body room;
  add_walls(scene, room, seed);
  add_posters(scene, room, seed);
  add_furniture(scene, room, seed);
  scene.bodies.push_back(std::move(room));
  return scene;
}

Body robot(Scene& scene, int id, std::uint32_t seed) {
  constexpr double kTexel_m = 0.0025;
  const Vector3d base(0.44, 0.25, 0.50);
  const Vector3d cargo(0.36, 0.45, 0.36);
  const double clearance_m = 0.05;
  const auto texture = [&](double w, double h, const Paint& paint) {
    return add_texture(scene, w, h, kTexel_m, paint);
  };
  const auto back = texture(base.x(), base.y(), robot_side(base.x(), base.y(), false, seed + 500));
  const auto flank = texture(base.z(), base.y(), robot_side(base.z(), base.y(), true, seed + 510));
  const auto cargo_front = texture(cargo.x(), cargo.y(), poster(cargo.x(), cargo.y(), seed + 520));
  const auto cargo_side = texture(cargo.z(), cargo.y(), poster(cargo.z(), cargo.y(), seed + 530));
  Body body;
  body.id = id;
  add_box(body, {{0, -clearance_m - 0.5 * base.y(), 0}, base}, back, flank);
  add_box(body, {{0, -clearance_m - base.y() - 0.5 * cargo.y(), 0}, cargo}, cargo_front,
          cargo_side);
  body.centre_m = {0, -0.5 * (clearance_m + base.y() + cargo.y()), 0};
  return body;
}

Trajectory steady(const SteadyMotion& m) {
  return [m](double t_s) {
    return pose(m.start_m + m.velocity_mps * t_s + 0.5 * t_s * t_s * m.acceleration_mps2,
                m.yaw_rad + m.yaw_rate_radps * t_s);
  };
}

Trajectory arc(const Vector3d& start_m, double yaw_rad, double speed_mps, double yaw_rate_radps) {
  if (std::abs(yaw_rate_radps) < 1e-9) {
    return steady(
        {.start_m = start_m,
         .velocity_mps = {speed_mps * std::sin(yaw_rad), 0, speed_mps * std::cos(yaw_rad)},
         .yaw_rad = yaw_rad});
  }
  const double radius_m = speed_mps / yaw_rate_radps;
  return [=](double t_s) {
    const double yaw = yaw_rad + yaw_rate_radps * t_s;
    const Vector3d moved(std::cos(yaw_rad) - std::cos(yaw), 0, std::sin(yaw) - std::sin(yaw_rad));
    return pose(start_m + radius_m * moved, yaw);
  };
}

Scene static_room() {
  Scene scene = furnished_room();
  scene.T_world_camera = s_curve(0.5, 0.15, 6.0);
  return scene;
}

Scene following_robot() {
  Scene scene = furnished_room();
  scene.T_world_camera = steady({.velocity_mps = {0, 0, 0.4}});
  push_robot(scene, 1,
             steady({.start_m = {0.1, kFloor_m, 1.8},
                     .velocity_mps = {0, 0, 0.4},
                     .acceleration_mps2 = {0, 0, 0.02}}));
  return scene;
}

Scene crossing_robot() {
  Scene scene = furnished_room();
  scene.T_world_camera = steady({.velocity_mps = {0, 0, 0.4}});
  push_robot(scene, 1, arc({-1.6, kFloor_m, 3.4}, 0.5 * M_PI, 0.6, 0.0));
  return scene;
}

}  // namespace egomod::test_support
