// SPDX-License-Identifier: Apache-2.0
#include "capture/calibration_check.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "capture/lens.hpp"

namespace egomod {
namespace {

constexpr int kMinSide_px = 16;
constexpr int kMaxSide_px = 16384;
// Far beyond what any rig has: what exceeds them is a slip, such as a wrong unit.
constexpr double kMaxFocalLength_sides = 1000.0;
constexpr double kMaxOffset_sides = 10.0;
constexpr double kMaxDistortion = 1e3;
constexpr double kMaxBaseline_m = 100.0;
constexpr double kOrthonormal = 1e-3;  // matrices printed with few digits pass

bool is_within(double value, double low, double high) { return value >= low && value <= high; }

int known(int side_px) { return side_px > 0 ? side_px : kMaxSide_px; }

std::string fault_of_pinhole(double fx_px, double fy_px, double cx_px, double cy_px, int width_px,
                             int height_px) {
  if (!is_focal_length(fx_px, width_px)) return std::string("fx ") + kFocalLengthRule;
  if (!is_focal_length(fy_px, height_px)) return std::string("fy ") + kFocalLengthRule;
  if (!is_principal_point(cx_px, width_px)) return std::string("cx ") + kPrincipalPointRule;
  if (!is_principal_point(cy_px, height_px)) return std::string("cy ") + kPrincipalPointRule;
  return {};
}

std::string fault_of(const StereoCamera& camera) {
  if (!is_image_size(camera.width_px, camera.height_px))
    return "the rectified image size is out of range";
  std::string fault = fault_of_pinhole(camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
                                       camera.width_px, camera.height_px);
  if (!fault.empty()) return fault;
  if (!is_baseline(camera.baseline_m)) return std::string("the baseline ") + kBaselineRule;
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
  const Eigen::Matrix3d& K = raw.K;
  const std::string fault =
      fault_of_pinhole(K(0, 0), K(1, 1), K(0, 2), K(1, 2), raw.width_px, raw.height_px);
  if (!fault.empty()) return "K of the " + name + " camera: " + fault;
  if (!is_distortion(raw.distortion)) {
    return "the distortion of the " + name + " camera " + kDistortionRule;
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

bool is_baseline(double baseline_m) { return baseline_m > 0.0 && baseline_m <= kMaxBaseline_m; }

bool is_distortion(std::span<const double> coefficients) {
  return std::ranges::all_of(
      coefficients, [](double d) { return is_within(d, -kMaxDistortion, kMaxDistortion); });
}

bool is_focal_length(double f_px, int side_px) {
  return f_px > 0.0 && f_px <= kMaxFocalLength_sides * known(side_px);
}

bool is_principal_point(double c_px, int side_px) {
  const double reach_px = kMaxOffset_sides * known(side_px);
  return is_within(c_px, -reach_px, known(side_px) + reach_px);
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
  if (fault.empty() && !is_baseline(calibration.t_right_left_m.norm())) {
    fault = std::string("the distance between the cameras ") + kBaselineRule;
  }
  if (fault.empty()) fault = fault_of(calibration.left, calibration.camera, "left");
  if (fault.empty()) fault = fault_of(calibration.right, calibration.camera, "right");
  return fault;
}

}  // namespace egomod
