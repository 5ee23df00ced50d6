// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>

#include "synthetic_world.hpp"

namespace egomod::test_support {

// 525 px, 0.375 m and 640x480, as two Kinects side by side; other sizes keep the field of view.
[[nodiscard]] StereoCamera kinect_pair(int width_px = 640);

// Builders. Sizes in metres; y points down, so that a box of height h on the floor y = floor_m has
// its centre at floor_m - h / 2.
struct Box {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();
};
[[nodiscard]] std::size_t add_texture(Scene& scene, double width_m, double height_m, double texel_m,
                                      const Paint& paint);
// Six faces, of which `front` (towards -z) and `side` (the others) name the textures.
void add_box(Body& body, const Box& box, std::size_t front, std::size_t side);

inline constexpr double kFloor_m = 0.45;  // below the camera of a scene's start

// An indoor room, 7 m wide, 12 m deep (the camera starts 1 m from the rear wall), with brick and
// plaster walls, tiles, posters, cartons and shelves. Nothing in it moves.
[[nodiscard]] Scene furnished_room(std::uint32_t seed = 1);

// A wheeled robot (0.44 x 0.75 x 0.50 m) whose frame has its origin on the floor, z its direction
// of view from behind. Adds its textures to the scene; give the result T_world_body and push it.
[[nodiscard]] Body robot(Scene& scene, int id, std::uint32_t seed = 1);

// Constant motion from a start: position + velocity t + acceleration t^2 / 2, yaw + rate t
// (positive: to the right), velocity in world axes.
struct SteadyMotion {
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;
  double yaw_rate_radps = 0.0;
};
[[nodiscard]] Trajectory steady(const SteadyMotion& motion);
// Drives where it looks: speed and yaw rate constant, a circular arc.
[[nodiscard]] Trajectory arc(const Eigen::Vector3d& start_m, double yaw_rad, double speed_mps,
                             double yaw_rate_radps);

// Ready-made worlds, all in `furnished_room`.
[[nodiscard]] Scene static_room();      // rig S-curves at 0.5 m/s, nothing moves
[[nodiscard]] Scene following_robot();  // rig 0.4 m/s, robot 1.8 m ahead at 0.4 + 0.02 t
[[nodiscard]] Scene crossing_robot();   // rig 0.4 m/s, robot crosses at 0.6 m/s, 3 m ahead

}  // namespace egomod::test_support
