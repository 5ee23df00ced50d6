// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include <algorithm>

namespace egomod::sim {
namespace {

using test_support::ObjectTruth;

constexpr double kResting_mps = 1e-3;

// Visible pixels, their rectangle and the mean of the points that they show.
void add_pixels(const StereoCamera& c, const Buffers& seen, ObjectTruth& truth) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::size_t i = 0;
  for (int v = 0; v < c.height_px; ++v) {
    for (int u = 0; u < c.width_px; ++u, ++i) {
      if (seen.ids[i] != truth.id) continue;
      const double z = seen.depth_m[i];
      sum_m += Eigen::Vector3d((u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px, 1.0) * z;
      test_support::grow(truth, u, v);
    }
  }
  if (truth.visible_px > 0) truth.surface_centroid_m = sum_m / truth.visible_px;
}

std::unique_ptr<DrivenBase> base_of(const World& world) {
  if (!world.rig.driven) return nullptr;
  return std::make_unique<DrivenBase>(*world.rig.driven, floor_of(world.shell), world.seed);
}

}  // namespace

Simulator::Simulator(World world)
    : world_(std::move(world)),
      base_(base_of(world_)),
      built_(build_scene(world_)),
      renderer_(built_.scene, world_.camera),
      sensor_(world_.realism, world_.camera.width_px, world_.camera.height_px, world_.seed) {
  if (!base_) return;
  built_.scene.T_world_camera = [rig = world_.rig, base = base_.get()](double t_s) {
    const BaseState state = base->at(t_s);
    return sim::T_world_camera(rig, state.pose, state.way_m);
  };
}

Calibration Simulator::calibration() const {
  Calibration calibration;
  calibration.camera = world_.camera;
  return calibration;
}

// As far as any exposure of the pair may reach.
void Simulator::go_on_to(std::uint64_t pair) {
  if (base_) base_->advance(time_s(pair + 1));
}

Eigen::Isometry3d Simulator::T_camera_world(int eye, double t_s) const {
  const Eigen::Isometry3d T_left_world = built_.scene.T_world_camera(t_s).inverse();
  return Eigen::Translation3d(-world_.camera.baseline_m * eye, 0, 0) * T_left_world;
}

void Simulator::blur(int eye, double t_s, Image& out) {
  const int samples = world_.realism.blur_samples;
  sums_.assign(static_cast<std::size_t>(world_.camera.width_px) *
                   static_cast<std::size_t>(world_.camera.height_px),
               static_cast<std::uint16_t>(samples / 2));
  for (int k = 0; k < samples; ++k) {
    const double t = t_s + ((k + 0.5) / samples - 0.5) * world_.realism.exposure_s;
    renderer_.render(t, T_camera_world(eye, t), sample_);
    std::uint16_t* sum = sums_.data();
    for (int v = 0; v < sample_.height_px(); ++v) {
      for (int u = 0; u < sample_.width_px(); ++u, ++sum) {
        *sum = static_cast<std::uint16_t>(*sum + sample_.row(v)[u]);
      }
    }
  }
  out.resize(world_.camera.width_px, world_.camera.height_px);
  const std::uint16_t* sum = sums_.data();
  for (int v = 0; v < out.height_px(); ++v) {
    for (int u = 0; u < out.width_px(); ++u, ++sum) {
      out.row(v)[u] = static_cast<std::uint8_t>(*sum / samples);
    }
  }
}

void Simulator::take(int eye, std::uint64_t pair, Image& out) {
  const double t_s = time_s(pair);
  if (world_.realism.blur_samples > 1) {
    blur(eye, t_s, out);
  } else {
    renderer_.render(t_s, T_camera_world(eye, t_s), out);
  }
  sensor_.expose(eye, pair, t_s, out);
}

void Simulator::take_pair(std::uint64_t pair, Image& left, Image& right) {
  go_on_to(pair);
  take(0, pair, left);
  take(1, pair, right);
}

ObjectState Simulator::state_of(const SceneObject& object, double t_s, const Buffers& seen) {
  const Eigen::Isometry3d T_world_camera = built_.scene.T_world_camera(t_s);
  const Eigen::Matrix3d R_camera_world = T_world_camera.linear().transpose();
  ObjectTruth truth;
  truth.id = object.id;
  truth.box_centre_m = T_world_camera.inverse() * (object.T_world_object(t_s) * object.centre_m);
  truth.surface_centroid_m = truth.box_centre_m;
  add_pixels(world_.camera, seen, truth);
  const auto motion = test_support::motion_of(object.T_world_object, t_s,
                                              T_world_camera * truth.surface_centroid_m);
  truth.velocity_mps = R_camera_world * motion.velocity_mps;
  truth.angular_velocity_radps = R_camera_world * motion.angular_radps;
  truth.moving = truth.velocity_mps.norm() > kResting_mps;
  if (truth.visible_px > 0) {
    renderer_.render_buffers(t_s, T_world_camera.inverse(), object.id, alone_);
    const auto alone = std::ranges::count(alone_.ids, static_cast<std::uint8_t>(object.id));
    truth.occluded_fraction =
        1.0 - static_cast<double>(truth.visible_px) / static_cast<double>(alone);
  }
  return {truth, object.kind};
}

void Simulator::take_truth(std::uint64_t pair, Truth& truth) {
  go_on_to(pair);
  const double t_s = time_s(pair);
  renderer_.render_buffers(t_s, T_camera_world(0, t_s), Renderer::kAll, truth.buffers);
  truth.T_first_current =
      built_.scene.T_world_camera(0.0).inverse() * built_.scene.T_world_camera(t_s);
  truth.objects.clear();
  for (const SceneObject& object : built_.objects) {
    truth.objects.push_back(state_of(object, t_s, truth.buffers));
  }
}

}  // namespace egomod::sim
