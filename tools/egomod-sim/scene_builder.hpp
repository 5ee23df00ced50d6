// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "synthetic_world.hpp"
#include "world.hpp"

namespace egomod::sim {

// An object as truth knows it; what it looks like are the scene's bodies with its id.
struct SceneObject {
  int id = 0;
  std::string kind;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of its box, in its own frame
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();    // of that box
  Trajectory T_world_object;
};

// Patches and textures of a world. World axes: x right, y down, z ahead, the floor at y = 0.
struct BuiltScene {
  test_support::Scene scene;
  std::vector<SceneObject> objects;
};
[[nodiscard]] BuiltScene build_scene(const World& world);

// Figures of several bodies: added to the scene with the id and trajectory given.
void add_person(test_support::Scene& scene, int id, const Motion& motion, std::uint32_t seed);
void add_car(test_support::Scene& scene, int id, const Trajectory& T_world_car, std::uint32_t seed);

[[nodiscard]] Trajectory on_floor(const Motion& motion);
// The left camera of a rig that stands there, after that way over an uneven floor.
[[nodiscard]] Eigen::Isometry3d T_world_camera(const Rig& rig, const PlanPose& at, double way_m);

}  // namespace egomod::sim
