// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/geometry.hpp"

#include <cmath>

namespace egomod {
namespace {

constexpr double kSmallAngle = 1e-4;  // below it, series to fourth order are exact to rounding

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d K;
  K << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return K;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi_rad) {
  const double angle2 = phi_rad.squaredNorm();
  const double angle = std::sqrt(angle2);
  const Eigen::Matrix3d K = skew(phi_rad);
  const bool small = angle < kSmallAngle;
  const double a = small ? 1.0 - angle2 / 6.0 : std::sin(angle) / angle;
  const double b = small ? 0.5 - angle2 / 24.0 : (1.0 - std::cos(angle)) / angle2;
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd rotation{Eigen::Quaterniond(R).normalized()};
  return rotation.angle() * rotation.axis();
}

// Barfoot eq. 7.85.
Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi_rad) {
  const double angle2 = phi_rad.squaredNorm();
  const double angle = std::sqrt(angle2);
  const Eigen::Matrix3d K = skew(phi_rad);
  const bool small = angle < kSmallAngle;
  const double a = small ? 0.5 - angle2 / 24.0 : (1.0 - std::cos(angle)) / angle2;
  const double b =
      small ? 1.0 / 6.0 - angle2 / 120.0 : (angle - std::sin(angle)) / (angle2 * angle);
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Isometry3d se3_exp(const Vector6d& xi) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = so3_exp(xi.tail<3>());
  T.translation() = so3_left_jacobian(xi.tail<3>()) * xi.head<3>();
  return T;
}

Vector6d se3_log(const Eigen::Isometry3d& T) {
  Vector6d xi;
  xi.tail<3>() = so3_log(T.linear());
  xi.head<3>() = so3_left_jacobian(xi.tail<3>()).inverse() * T.translation();
  return xi;
}

Matrix6d adjoint(const Eigen::Isometry3d& T) {
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T.linear();
  Ad.bottomRightCorner<3, 3>() = T.linear();
  Ad.topRightCorner<3, 3>() = skew(T.translation()) * T.linear();
  return Ad;
}

Eigen::Isometry3d orthonormalised(const Eigen::Isometry3d& T) {
  Eigen::Isometry3d result = T;
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return result;
}

Eigen::Vector3d project(const StereoCamera& camera, const Eigen::Vector3d& P_m) {
  const double inverse_z = 1.0 / P_m.z();
  return {camera.fx_px * P_m.x() * inverse_z + camera.cx_px,
          camera.fy_px * P_m.y() * inverse_z + camera.cy_px,
          camera.fx_px * camera.baseline_m * inverse_z};
}

Eigen::Matrix3d project_jacobian(const StereoCamera& camera, const Eigen::Vector3d& P_m) {
  const double inverse_z = 1.0 / P_m.z();
  const double inverse_z2 = inverse_z * inverse_z;
  Eigen::Matrix3d J;
  J << camera.fx_px * inverse_z, 0, -camera.fx_px * P_m.x() * inverse_z2,  //
      0, camera.fy_px * inverse_z, -camera.fy_px * P_m.y() * inverse_z2,   //
      0, 0, -camera.fx_px * camera.baseline_m * inverse_z2;
  return J;
}

Eigen::Vector3d triangulate(const StereoCamera& camera, const Eigen::Vector3d& uvd_px) {
  const double z = camera.fx_px * camera.baseline_m / uvd_px.z();
  return {(uvd_px.x() - camera.cx_px) * z / camera.fx_px,
          (uvd_px.y() - camera.cy_px) * z / camera.fy_px, z};
}

Eigen::Matrix3d triangulate_jacobian(const StereoCamera& camera, const Eigen::Vector3d& uvd_px) {
  const Eigen::Vector3d P = triangulate(camera, uvd_px);
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J(0, 0) = P.z() / camera.fx_px;
  J(1, 1) = P.z() / camera.fy_px;
  J.col(2) = -P / uvd_px.z();
  return J;
}

Eigen::Vector3d row_displacement_per_s(const StereoCamera& camera, const Eigen::Vector3d& P_m,
                                       const Vector6d& velocity) {
  const double v_px = camera.fy_px * P_m.y() / P_m.z() + camera.cy_px;
  const double rows_late = v_px / camera.height_px - 0.5;
  const Eigen::Vector3d approach_mps = velocity.head<3>() + velocity.tail<3>().cross(P_m);
  return project_jacobian(camera, P_m) * (-rows_late * approach_mps);
}

Eigen::Vector3d at_middle_row(const StereoCamera& camera, const Eigen::Vector3d& uvd_px,
                              const RowTiming& rows) {
  if (rows.readout_s == 0.0 || !(uvd_px.z() > 0.0) || camera.height_px <= 0) return uvd_px;
  const Eigen::Vector3d P = triangulate(camera, uvd_px);
  return uvd_px - rows.readout_s * row_displacement_per_s(camera, P, rows.velocity);
}

Eigen::Vector3d uvd(const StereoObservation& o) { return {o.u_px, o.v_px, o.disparity_px}; }

Eigen::Matrix3d covariance(const StereoObservation& o) {
  const auto& c = o.covariance_px2;
  Eigen::Matrix3d S;
  S << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  return S;
}

}  // namespace egomod
