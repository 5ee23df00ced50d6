// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

namespace egomod::sim {
namespace {

using test_support::ObjectTruth;

constexpr double kResting_mps = 1e-3;
constexpr double kResting_radps = 1e-3;

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
      cameras_{build_camera(Eye::kLeft), build_camera(Eye::kRight)},
      sensor_(world_.realism, world_.camera.width_px, world_.camera.height_px, world_.seed),
      first_s_(first_left_exposure(world_).t_s) {
  if (!base_) return;
  built_.scene.T_world_camera = [rig = world_.rig, base = base_.get()](double t_s) {
    const BaseState state = base->at(t_s);
    return sim::T_world_camera(rig, state.pose, state.way_m);
  };
}

// A driven rig's motion is known as far as an exposure then reaches.
void Simulator::go_on_to(double t_s) {
  const Realism& r = world_.realism;
  if (base_) base_->advance(t_s + 0.5 * (r.exposure_s + r.readout_s) + DrivenBase::kTick_s);
}

Simulator::Camera Simulator::build_camera(Eye eye) const {
  const RealCamera real = real_camera(world_.camera, world_.optics, eye);
  const Realism& r = world_.realism;
  ImageFormation formation(real.raw, {r.readout_s, r.readout_strips});
  const auto canvas =
      renderer_.make_canvas(formation.pinhole().width_px, formation.canvas_height_px());
  return {eye, real, std::move(formation), canvas, {}, {}};
}

Eigen::Isometry3d Simulator::T_left_world(double t_s) const {
  return built_.scene.T_world_camera(t_s).inverse();
}

void Simulator::draw(Camera& camera, double t_s) {
  Eigen::Isometry3d T_camera_left = Eigen::Isometry3d::Identity();
  T_camera_left.linear() = camera.real.raw.R_rectified_raw.transpose();
  T_camera_left.translate(Eigen::Vector3d(-camera.real.x_m, 0, 0));
  camera.views.clear();
  for (const ImageFormation::Strip& strip : camera.formation.strips()) {
    const double t = t_s + strip.offset_s;
    camera.views.push_back({t, T_camera_left * T_left_world(t), strip.first_view_row,
                            strip.end_view_row, strip.canvas_row});
  }
  renderer_.draw(camera.canvas, camera.formation.pinhole(), camera.views);
}

// The last sample leaves their mean in `out`.
void Simulator::add_sample(Camera& camera, Image& out) {
  const int samples = world_.realism.blur_samples;
  const auto width = static_cast<std::size_t>(out.width_px());
  camera.sums.resize(width * static_cast<std::size_t>(out.height_px()),
                     static_cast<std::uint16_t>(samples / 2));
  std::uint16_t* sum = camera.sums.data();
  for (int v = 0; v < out.height_px(); ++v, sum += width) {
    std::uint8_t* row = out.row(v);
    for (std::size_t u = 0; u < width; ++u) {
      sum[u] = static_cast<std::uint16_t>(sum[u] + row[u]);
      row[u] = static_cast<std::uint8_t>(sum[u] / samples);
    }
  }
}

void Simulator::take(std::span<const Shot> shots) {
  const Realism& r = world_.realism;
  for (const Shot& shot : shots) {
    shot.camera.sums.clear();
    go_on_to(exposure(world_, shot.camera.eye, shot.number).t_s);
  }
  for (int k = 0; k < r.blur_samples; ++k) {
    const double offset_s = ((k + 0.5) / r.blur_samples - 0.5) * r.exposure_s;
    for (const auto& [camera, number, out] : shots) {
      draw(camera, exposure(world_, camera.eye, number).t_s + offset_s);
    }
    for (const auto& [camera, number, out] : shots) {
      renderer_.read(camera.canvas, canvas_);
      camera.formation.develop(canvas_, out);
      if (r.blur_samples > 1) add_sample(camera, out);
    }
  }
  for (const auto& [camera, number, out] : shots) {
    sensor_.expose(static_cast<int>(camera.eye), number, exposure(world_, camera.eye, number).t_s,
                   out);
  }
}

void Simulator::take_pair(std::uint64_t number, Image& left, Image& right) {
  take(std::array<Shot, 2>{{{cameras_[0], number, left}, {cameras_[1], number, right}}});
}

void Simulator::take_image(Eye eye, std::uint64_t number, Image& out) {
  take(std::array<Shot, 1>{{{cameras_[static_cast<std::size_t>(eye)], number, out}}});
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
  truth.moving = truth.velocity_mps.norm() > kResting_mps ||
                 truth.angular_velocity_radps.norm() > kResting_radps;
  if (truth.visible_px > 0) {
    const int alone = renderer_.count_alone(t_s, T_world_camera.inverse(), object.id);
    truth.occluded_fraction = 1.0 - static_cast<double>(truth.visible_px) / alone;
  }
  const Eigen::Matrix3d R_camera_object = R_camera_world * object.T_world_object(t_s).linear();
  return {truth, object.kind, R_camera_object.cwiseAbs() * object.size_m};
}

void Simulator::take_truth(std::uint64_t number, Truth& truth) {
  const double t_s = time_s(number);
  go_on_to(t_s);
  if (!T_first_world_) T_first_world_ = T_left_world(first_s_);
  const Trajectory& rig = built_.scene.T_world_camera;
  const Eigen::Isometry3d T_world_camera = rig(t_s);
  const auto motion = test_support::motion_of(rig, t_s, T_world_camera.translation());
  renderer_.render_buffers(t_s, T_world_camera.inverse(), truth.buffers);
  truth.T_first_current = *T_first_world_ * T_world_camera;
  truth.velocity_mps = T_world_camera.linear().transpose() * motion.velocity_mps;
  truth.angular_velocity_radps = T_world_camera.linear().transpose() * motion.angular_radps;
  truth.objects.clear();
  for (const SceneObject& object : built_.objects) {
    truth.objects.push_back(state_of(object, t_s, truth.buffers));
  }
}

}  // namespace egomod::sim
