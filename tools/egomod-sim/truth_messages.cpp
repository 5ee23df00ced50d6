// SPDX-License-Identifier: Apache-2.0
#include "truth_messages.hpp"

#include <Eigen/Geometry>

namespace egomod::sim {
namespace {

using Eigen::Vector3d;

Eigen::Isometry3d T_world_body(const Truth& truth, const Eigen::Isometry3d& T_body_camera) {
  return T_body_camera * truth.T_first_current * T_body_camera.inverse();
}

void write_orientation(const Eigen::Matrix3d& R, double (&to)[4]) {
  Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  to[0] = q.w();
  to[1] = q.x();
  to[2] = q.y();
  to[3] = q.z();
}

truth_object_t message_of(const ObjectState& object, const Eigen::Isometry3d& T_body_camera,
                          const Eigen::Isometry3d& T_world) {
  const test_support::ObjectTruth& truth = object.truth;
  const Vector3d position_m = T_body_camera * truth.surface_centroid_m;
  const Vector3d velocity_mps = T_body_camera.linear() * truth.velocity_mps;
  truth_object_t message{};
  message.id = truth.id;
  Vector3d::Map(message.pos) = T_world * position_m;
  Vector3d::Map(message.vel) = T_world.linear() * velocity_mps;
  Vector3d::Map(message.body_pos) = position_m;
  Vector3d::Map(message.body_vel) = velocity_mps;
  Vector3d::Map(message.extent) = object.extent_m;
  message.u_min = static_cast<float>(truth.u_min_px);
  message.v_min = static_cast<float>(truth.v_min_px);
  message.u_max = static_cast<float>(truth.u_max_px);
  message.v_max = static_cast<float>(truth.v_max_px);
  message.visible = truth.visible_px;
  message.moving = truth.moving ? 1 : 0;
  return message;
}

}  // namespace

void fill_message(const Truth& truth, const Eigen::Isometry3d& T_body_camera, std::int64_t utime,
                  std::int64_t sequence, truth_pose_t& message) {
  const Eigen::Isometry3d T = T_world_body(truth, T_body_camera);
  // Of the body's origin, which the camera carries along.
  const Vector3d origin_m = T_body_camera.inverse().translation();
  const Vector3d velocity_mps = truth.velocity_mps + truth.angular_velocity_radps.cross(origin_m);
  message.utime = utime;
  message.sequence = sequence;
  Vector3d::Map(message.pos) = T.translation();
  write_orientation(T.linear(), message.orientation);
  Vector3d::Map(message.vel) = T_body_camera.linear() * velocity_mps;
  Vector3d::Map(message.rotation_rate) = T_body_camera.linear() * truth.angular_velocity_radps;
}

void fill_message(const Truth& truth, const Eigen::Isometry3d& T_body_camera, std::int64_t utime,
                  std::int64_t sequence, truth_object_list_t& message) {
  const Eigen::Isometry3d T = T_world_body(truth, T_body_camera);
  message.utime = utime;
  message.sequence = sequence;
  message.n_objects = static_cast<std::int32_t>(truth.objects.size());
  message.objects.clear();
  for (const ObjectState& object : truth.objects) {
    message.objects.push_back(message_of(object, T_body_camera, T));
  }
}

}  // namespace egomod::sim
