// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "egomod/core/image.hpp"
#include "renderer.hpp"
#include "scene_builder.hpp"
#include "sensor.hpp"
#include "world.hpp"

namespace egomod::sim {

struct ObjectState {
  test_support::ObjectTruth truth;
  std::string kind;
};

// What is true at one instant, and where it was read from.
struct Truth {
  Eigen::Isometry3d T_first_current = Eigen::Isometry3d::Identity();  // left camera
  std::vector<ObjectState> objects;
  Buffers buffers;  // of the left camera
};

// A world that can be looked at, at any time and in any order; where the rig is driven, in order of
// time, since what it will be told is not known. Threads: as Renderer.
class Simulator {
 public:
  explicit Simulator(World world);

  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const BuiltScene& built() const { return built_; }
  [[nodiscard]] Calibration calibration() const;
  // The base that carries the rig; nullptr where it follows its own trajectory.
  [[nodiscard]] DrivenBase* base() { return base_.get(); }
  [[nodiscard]] double time_s(std::uint64_t pair) const {
    return static_cast<double>(pair) / world_.rate_hz;
  }
  // Exposures begin half of their length before the pair's time.
  void take_pair(std::uint64_t pair, Image& left, Image& right);
  void take_truth(std::uint64_t pair, Truth& truth);
  [[nodiscard]] std::string device() const { return renderer_.device(); }

 private:
  void go_on_to(std::uint64_t pair);
  void take(int eye, std::uint64_t pair, Image& out);
  void blur(int eye, double t_s, Image& out);
  [[nodiscard]] Eigen::Isometry3d T_camera_world(int eye, double t_s) const;
  [[nodiscard]] ObjectState state_of(const SceneObject& object, double t_s, const Buffers& seen);

  World world_;
  std::unique_ptr<DrivenBase> base_;  // the scene's rig asks it
  BuiltScene built_;
  Renderer renderer_;
  Sensor sensor_;
  Image sample_;
  std::vector<std::uint16_t> sums_;
  Buffers alone_;
};

}  // namespace egomod::sim
