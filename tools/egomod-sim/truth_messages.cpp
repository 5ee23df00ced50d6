// SPDX-License-Identifier: Apache-2.0
#include "truth_messages.hpp"

#include <algorithm>

namespace egomod::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test_support::ObjectTruth;

// The world of the messages is the body frame of the first pair.
Isometry3d T_world_body(const Simulator& simulator, const Truth& truth) {
  const Isometry3d T_body_camera = simulator.calibration().T_body_camera;
  return T_body_camera * truth.T_first_current * T_body_camera.inverse();
}

// One sign of the two that mean the same rotation.
void write_orientation(const Eigen::Matrix3d& R, double (&to)[4]) {
  Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  to[0] = q.w();
  to[1] = q.x();
  to[2] = q.y();
  to[3] = q.z();
}

// Of the box around the object, along the camera's axes.
Vector3d extent_m(const Simulator& simulator, const SceneObject& object, double t_s) {
  const auto thing = std::ranges::find(simulator.world().things, object.id, &Thing::id);
  const Eigen::Matrix3d R_camera_object =
      simulator.built().scene.T_world_camera(t_s).linear().transpose() *
      object.T_world_object(t_s).linear();
  return R_camera_object.cwiseAbs() * size_m(*thing);
}

void fill(const ObjectTruth& truth, const Isometry3d& T_body_camera, const Isometry3d& T_world_body,
          truth_object_t& out) {
  const Vector3d body_pos = T_body_camera * truth.surface_centroid_m;
  const Vector3d body_vel = T_body_camera.linear() * truth.velocity_mps;
  out.id = truth.id;
  Vector3d::Map(out.pos) = T_world_body * body_pos;
  Vector3d::Map(out.vel) = T_world_body.linear() * body_vel;
  Vector3d::Map(out.body_pos) = body_pos;
  Vector3d::Map(out.body_vel) = body_vel;
  out.u_min = static_cast<float>(truth.u_min_px);
  out.v_min = static_cast<float>(truth.v_min_px);
  out.u_max = static_cast<float>(truth.u_max_px);
  out.v_max = static_cast<float>(truth.v_max_px);
  out.visible = truth.visible_px;
  out.moving = truth.moving ? 1 : 0;
}

}  // namespace

void fill_message(const Simulator& simulator, double t_s, const Truth& truth,
                  truth_pose_t& message) {
  const Isometry3d T = T_world_body(simulator, truth);
  const auto& T_world_camera = simulator.built().scene.T_world_camera;
  const Isometry3d T_body_camera = simulator.calibration().T_body_camera;
  const Isometry3d T_world_body_now = T_world_camera(t_s) * T_body_camera.inverse();
  const auto motion = test_support::motion_of(T_world_camera, t_s, T_world_body_now.translation());
  const Eigen::Matrix3d R_body_world = T_world_body_now.linear().transpose();
  Vector3d::Map(message.pos) = T.translation();
  write_orientation(T.linear(), message.orientation);
  Vector3d::Map(message.vel) = R_body_world * motion.velocity_mps;
  Vector3d::Map(message.rotation_rate) = R_body_world * motion.angular_radps;
}

void fill_message(const Simulator& simulator, double t_s, const Truth& truth,
                  truth_object_list_t& message) {
  const Isometry3d T = T_world_body(simulator, truth);
  message.n_objects = static_cast<std::int32_t>(truth.objects.size());
  message.objects.resize(truth.objects.size());
  for (std::size_t i = 0; i < truth.objects.size(); ++i) {
    truth_object_t& out = message.objects[i];
    fill(truth.objects[i].truth, simulator.calibration().T_body_camera, T, out);
    Vector3d::Map(out.extent) = extent_m(simulator, simulator.built().objects[i], t_s);
  }
}

}  // namespace egomod::sim
