// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/trifocal.hpp"

#include <Eigen/LU>

#include "egomod/egomotion/correspondence.hpp"

namespace egomod {
namespace {

Eigen::Matrix3d intrinsics(const StereoCamera& camera) {
  Eigen::Matrix3d K;
  K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  return K;
}

CameraMatrix camera_matrix(const Eigen::Matrix3d& K, const Eigen::Isometry3d& T_camera_world) {
  CameraMatrix P;
  P << K * T_camera_world.linear(), K * T_camera_world.translation();
  return P;
}

}  // namespace

TrifocalTensor trifocal_tensor(const Eigen::Matrix3d& K, const CameraMatrix& P_B,
                               const CameraMatrix& P_C) {
  const Eigen::Matrix3d K_inverse = K.inverse();
  const Eigen::Matrix3d B = P_B.leftCols<3>() * K_inverse;
  const Eigen::Matrix3d C = P_C.leftCols<3>() * K_inverse;
  TrifocalTensor tensor;
  for (int i = 0; i < 3; ++i)
    tensor[static_cast<std::size_t>(i)] =
        B.col(i) * P_C.col(3).transpose() - P_B.col(3) * C.col(i).transpose();
  return tensor;
}

Eigen::Vector3d transfer(const TrifocalTensor& tensor, double u_right_px, double v_px,
                         double u_left_px) {
  const auto by_line = [&](const Eigen::Matrix3d& T) {
    return (T.row(0) - u_left_px * T.row(2)).transpose();
  };
  return u_right_px * by_line(tensor[0]) + v_px * by_line(tensor[1]) + by_line(tensor[2]);
}

StereoTransfer::StereoTransfer(const StereoCamera& camera,
                               const Eigen::Isometry3d& T_current_previous) {
  const Eigen::Matrix3d K = intrinsics(camera);
  const Eigen::Isometry3d T_left_right{Eigen::Translation3d(camera.baseline_m, 0, 0)};
  const Eigen::Isometry3d T_left_world = T_current_previous * T_left_right;
  const CameraMatrix P_previous_left = camera_matrix(K, T_left_right);
  to_left_ = trifocal_tensor(K, P_previous_left, camera_matrix(K, T_left_world));
  to_right_ =
      trifocal_tensor(K, P_previous_left, camera_matrix(K, T_left_right.inverse() * T_left_world));
}

bool StereoTransfer::operator()(const Eigen::Vector3d& previous_uvd_px,
                                Eigen::Vector4d& current_px) const {
  const double u_left = previous_uvd_px.x();
  const double u_right = u_left - previous_uvd_px.z();
  const Eigen::Vector3d left = transfer(to_left_, u_right, previous_uvd_px.y(), u_left);
  const Eigen::Vector3d right = transfer(to_right_, u_right, previous_uvd_px.y(), u_left);
  current_px << left.hnormalized(), right.hnormalized();
  return left.z() < -kMinDepthM * previous_uvd_px.z() && current_px.allFinite();
}

}  // namespace egomod
