// SPDX-License-Identifier: Apache-2.0
#include "capture/calibration_check.hpp"

#include <Eigen/LU>
#include <cmath>

#include "capture/lens.hpp"

namespace egomod {
namespace {

constexpr int kMinSide_px = 16;
constexpr int kMaxSide_px = 16384;
constexpr double kOrthonormal = 1e-3;  // matrices printed with few digits pass

bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }

std::string fault_of(const StereoCamera& camera) {
  if (!is_positive(camera.fx_px) || !is_positive(camera.fy_px)) {
    return "focal lengths must be positive";
  }
  if (!std::isfinite(camera.cx_px) || !std::isfinite(camera.cy_px)) {
    return "the principal point is not finite";
  }
  if (!is_positive(camera.baseline_m)) return "the baseline must be positive";
  if (!is_image_size(camera.width_px, camera.height_px))
    return "the rectified image size is out of range";
  return {};
}

// The middle of the rectified image must come from the raw one, else all of it is border.
bool sees_middle(const RawCamera& raw, const StereoCamera& camera) {
  const Eigen::Vector3d ray((0.5 * camera.width_px - camera.cx_px) / camera.fx_px,
                            (0.5 * camera.height_px - camera.cy_px) / camera.fy_px, 1.0);
  const Eigen::Vector3d x = raw.R_rectified_raw.transpose() * ray;
  if (!(x.z() > 0.0)) return false;
  const Eigen::Vector2d pixel = Lens(raw).pixel(x.hnormalized());
  return pixel.x() > 0.0 && pixel.y() > 0.0 && pixel.x() < raw.width_px &&
         pixel.y() < raw.height_px;
}

std::string fault_of(const RawCamera& raw, const StereoCamera& camera, const std::string& name) {
  if (!is_image_size(raw.width_px, raw.height_px))
    return "the raw image size of the " + name + " camera is out of range";
  if (!is_camera_matrix(raw.K)) {
    return "K of the " + name + " camera must be [fx s cx; 0 fy cy; 0 0 1]";
  }
  for (const double d : raw.distortion) {
    if (!std::isfinite(d)) return "the distortion of the " + name + " camera is not finite";
  }
  if (!is_rotation(raw.R_rectified_raw)) {
    return "the rectification of the " + name + " camera is not a rotation";
  }
  if (!sees_middle(raw, camera)) {
    return "the rectified image lies outside of the " + name + " camera's view";
  }
  return {};
}

}  // namespace

bool is_image_size(double width_px, double height_px) {
  const auto is_side = [](double side) {
    return side >= kMinSide_px && side <= kMaxSide_px && side == std::floor(side);
  };
  return is_side(width_px) && is_side(height_px);
}

bool is_rotation(const Eigen::Matrix3d& R) {
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  return error < kOrthonormal && R.determinant() > 0.0;
}

bool is_rigid_transform(const Eigen::Matrix4d& T) {
  return T.allFinite() && is_rotation(T.topLeftCorner<3, 3>()) &&
         T.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
}

bool is_camera_matrix(const Eigen::Matrix3d& K) {
  return K.allFinite() && K(1, 0) == 0.0 && K(2, 0) == 0.0 && K(2, 1) == 0.0 && K(2, 2) == 1.0 &&
         K(0, 0) > 0.0 && K(1, 1) > 0.0;
}

std::string fault_of(const Calibration& calibration) {
  std::string fault = fault_of(calibration.camera);
  if (fault.empty() && !is_rigid_transform(calibration.T_body_camera.matrix())) {
    fault = "T_body_camera is not a rigid transform";
  }
  if (!calibration.images_are_raw) return fault;
  if (fault.empty() && !is_rotation(calibration.R_right_left)) {
    fault = "the rotation between the cameras is not one";
  }
  if (fault.empty() && !calibration.t_right_left_m.allFinite()) {
    fault = "the translation between the cameras is not finite";
  }
  if (fault.empty()) fault = fault_of(calibration.left, calibration.camera, "left");
  if (fault.empty()) fault = fault_of(calibration.right, calibration.camera, "right");
  return fault;
}

}  // namespace egomod
