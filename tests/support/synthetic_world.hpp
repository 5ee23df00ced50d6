// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "texture.hpp"

namespace egomod::test_support {

using Trajectory = std::function<Eigen::Isometry3d(double t_s)>;

// A textured parallelogram: points corner + s * edge_s + t * edge_t with s, t in 0..1.
struct Patch {
  Eigen::Vector3d corner_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d edge_s_m = Eigen::Vector3d::UnitX();
  Eigen::Vector3d edge_t_m = Eigen::Vector3d::UnitY();
  std::size_t texture = 0;    // index into Scene::textures
  double brightness = 1.0;    // light on this face
  bool is_seen_flat = false;  // usually at a grazing angle: worth a costlier texture filter
};

// Patches that move as one. Id 0: scenery.
struct Body {
  int id = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of its box, in its own frame
  std::vector<Patch> patches;
  Trajectory T_world_body = [](double) { return Eigen::Isometry3d::Identity(); };
};

// World axes as a level camera's: x right, y down, z forward.
struct Scene {
  std::vector<Texture> textures;
  std::vector<Body> bodies;
  Trajectory T_world_camera = [](double) { return Eigen::Isometry3d::Identity(); };  // left camera
};

struct RenderOptions {
  double noise_sigma = 0.0;  // grey levels
  std::uint32_t seed = 1;
};

// What is true of a body with id > 0. Left camera axes at t; velocities relative to the static
// world. The rectangle is inclusive; the unset one of an invisible body has u_min_px > u_max_px.
struct ObjectTruth {
  int id = 0;
  Eigen::Vector3d surface_centroid_m = Eigen::Vector3d::Zero();  // of its visible surface
  Eigen::Vector3d box_centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // of the point at the surface centroid
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  int u_min_px = 1;
  int v_min_px = 1;
  int u_max_px = 0;
  int v_max_px = 0;
  int visible_px = 0;
  double occluded_fraction = 0.0;  // of the pixels inside the image that it would show alone
  bool moving = false;             // faster than 1 mm/s
};

// Counts a visible pixel and widens the rectangle to it.
void grow(ObjectTruth& truth, int u_px, int v_px);

// Of the body's point that is at `P_world_m` now; central differences in world axes.
struct BodyMotion {
  Eigen::Vector3d velocity_mps;
  Eigen::Vector3d angular_radps;
};
[[nodiscard]] BodyMotion motion_of(const Trajectory& T_world_body, double t_s,
                                   const Eigen::Vector3d& P_world_m);

// What the left camera sees, pixel by pixel (row-major, at pixel centres).
struct PixelTruth {
  std::vector<float> depth_m;  // 0 where nothing is hit
  std::vector<int> body_id;    // 0 for scenery and nothing
};

// Renders what a stereo rig sees of a scene, with exact truth. Deterministic; noise depends on
// seed, time and camera only. Threads: const calls may run at the same time.
class SyntheticWorld {
 public:
  SyntheticWorld(Scene scene, const StereoCamera& camera, const RenderOptions& options = {});

  [[nodiscard]] const StereoCamera& camera() const { return camera_; }
  [[nodiscard]] const Scene& scene() const { return scene_; }

  void render(double t_s, Image& left, Image& right) const;
  // Left camera now in the left camera's frame at t = 0.
  [[nodiscard]] Eigen::Isometry3d T_first_current(double t_s) const;
  [[nodiscard]] std::vector<ObjectTruth> objects(double t_s) const;
  [[nodiscard]] PixelTruth pixels(double t_s) const;

 private:
  void render_eye(double t_s, const Eigen::Isometry3d& T_camera_world, std::uint32_t eye,
                  Image& out) const;

  Scene scene_;
  StereoCamera camera_;
  RenderOptions options_;
};

}  // namespace egomod::test_support
