// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "egomod/core/image.hpp"
#include "exposures.hpp"
#include "image_formation.hpp"
#include "renderer.hpp"
#include "scene_builder.hpp"
#include "sensor.hpp"
#include "world.hpp"

namespace egomod::sim {

struct ObjectState {
  test_support::ObjectTruth truth;
  std::string kind;
  Eigen::Vector3d extent_m = Eigen::Vector3d::Zero();  // along the left camera's axes
};

// What is true at the instant of a left image, in left camera axes, and where it was read from.
struct Truth {
  Eigen::Isometry3d T_first_current = Eigen::Isometry3d::Identity();  // left camera
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();             // of the left camera
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  std::vector<ObjectState> objects;
  Buffers buffers;  // of the rectified left camera
};

// A world that can be looked at, at any time and in any order; where the rig is driven, in order of
// time, since what it will be told is not known. Threads: as Renderer.
class Simulator {
 public:
  explicit Simulator(World world);

  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const BuiltScene& built() const { return built_; }
  // As it is written, for all who read images of it.
  [[nodiscard]] Calibration calibration() const {
    return written_calibration(world_.camera, world_.optics);
  }
  // The base that carries the rig; nullptr where it follows its own trajectory.
  [[nodiscard]] DrivenBase* base() { return base_.get(); }
  // When the left camera takes image `number`.
  [[nodiscard]] double time_s(std::uint64_t number) const {
    return exposure(world_, Eye::kLeft, number).t_s;
  }
  // Image `number` of each camera, each at its own time, as if none got lost.
  void take_pair(std::uint64_t number, Image& left, Image& right);
  void take_image(Eye eye, std::uint64_t number, Image& out);
  void take_truth(std::uint64_t number, Truth& truth);
  [[nodiscard]] std::string device() const { return renderer_.device(); }

 private:
  struct Camera {
    Eye eye;
    RealCamera real;
    ImageFormation formation;
    Renderer::Canvas canvas;
    std::vector<View> views;
    std::vector<std::uint16_t> sums;
  };
  // A camera and what it shall take.
  struct Shot {
    Camera& camera;
    std::uint64_t number;
    Image& out;
  };
  [[nodiscard]] Camera build_camera(Eye eye) const;
  void go_on_to(double t_s);
  void take(std::span<const Shot> shots);
  void draw(Camera& camera, double t_s);
  void add_sample(Camera& camera, Image& out);
  [[nodiscard]] Eigen::Isometry3d T_left_world(double t_s) const;
  [[nodiscard]] ObjectState state_of(const SceneObject& object, double t_s, const Buffers& seen);

  World world_;
  std::unique_ptr<DrivenBase> base_;  // the scene's rig asks it
  BuiltScene built_;
  Renderer renderer_;
  std::array<Camera, 2> cameras_;
  Sensor sensor_;
  double first_s_;                                  // of the first left image
  std::optional<Eigen::Isometry3d> T_first_world_;  // its camera's pose
  Image canvas_;
};

}  // namespace egomod::sim
