// SPDX-License-Identifier: Apache-2.0
#include "optics.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace egomod::sim {
namespace {

constexpr int kNewtonSteps = 50;
constexpr double kExact = 1e-12;
constexpr double kLargestStep = 0.2;  // of a direction: Newton must not jump over a fold
constexpr double kSteepest_z = 0.05;  // 87 degrees off the axis
constexpr int kBorderStep_px = 8;

Eigen::Matrix2d derivative(const Distortion& lens, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = lens;
  const auto [x, y] = std::pair{p.x(), p.y()};
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2.0 * k1 + r2 * (4.0 * k2 + r2 * 6.0 * k3);
  const double mixed = x * y * slope + 2.0 * (p1 * x + p2 * y);
  Eigen::Matrix2d J;
  J << radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return J;
}

// A fold turns the picture inside out.
bool is_upright(const Eigen::Matrix2d& J) { return J.determinant() > 0.0 && J.trace() > 0.0; }

Eigen::Matrix3d rotation(double yaw_rad, double pitch_rad, double roll_rad) {
  return (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

CameraBuild ideal(const StereoCamera& c) {
  return {.focal_px = c.fx_px, .cx_px = c.cx_px, .cy_px = c.cy_px};
}

RawCamera built(const StereoCamera& rectified, const CameraBuild& build) {
  RawCamera raw;
  raw.width_px = rectified.width_px;
  raw.height_px = rectified.height_px;
  raw.K << build.focal_px, 0, build.cx_px, 0, build.focal_px, build.cy_px, 0, 0, 1;
  raw.distortion = build.distortion;
  raw.R_rectified_raw = rotation(build.yaw_rad, build.pitch_rad, build.roll_rad);
  return raw;
}

// Calls `use` with the pixels of the border and of a grid inside.
template <typename Use>
void for_sample_pixels(int width_px, int height_px, const Use& use) {
  const auto next = [](int at, int size_px) {
    return at + 1 == size_px ? size_px : std::min(at + kBorderStep_px, size_px - 1);
  };
  for (int v = 0; v < height_px; v = next(v, height_px)) {
    for (int u = 0; u < width_px; u = next(u, width_px)) use(u, v);
  }
}

}  // namespace

Eigen::Vector2d distorted(const Distortion& lens, const Eigen::Vector2d& direction) {
  const auto& [k1, k2, p1, p2, k3] = lens;
  const auto [x, y] = std::pair{direction.x(), direction.y()};
  const double r2 = direction.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return radial * direction + Eigen::Vector2d(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                                              p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
}

std::optional<Eigen::Vector2d> undistorted(const Distortion& lens, const Eigen::Vector2d& image) {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Eigen::Matrix2d J = derivative(lens, p);
    if (!is_upright(J)) return std::nullopt;
    Eigen::Vector2d change = J.inverse() * (image - distorted(lens, p));
    const double length = change.norm();
    if (length < kExact) return p;
    p += change * std::min(1.0, kLargestStep / length);
  }
  return std::nullopt;
}

Calibration written_calibration(const StereoCamera& rectified, const Optics& optics) {
  Calibration calibration;
  calibration.camera = rectified;
  if (!optics.images_are_raw) return calibration;
  calibration.images_are_raw = true;
  calibration.left = built(rectified, optics.left);
  calibration.right = built(rectified, optics.right);
  const Eigen::Matrix3d R_raw_rectified = calibration.right.R_rectified_raw.transpose();
  calibration.R_right_left = R_raw_rectified * calibration.left.R_rectified_raw;
  calibration.t_right_left_m = R_raw_rectified * Eigen::Vector3d(-rectified.baseline_m, 0, 0);
  return calibration;
}

RealCamera real_camera(const StereoCamera& rectified, const Optics& optics, Eye eye) {
  const bool is_left = eye == Eye::kLeft;
  const CameraBuild& build = is_left ? optics.left : optics.right;
  RealCamera camera{built(rectified, optics.images_are_raw ? build : ideal(rectified)), 0.0};
  if (is_left) return camera;
  const CalibrationError& e = optics.error;
  camera.raw.K.topLeftCorner<2, 2>() *= e.right_focal_ratio;
  camera.raw.R_rectified_raw *= rotation(e.right_yaw_rad, e.right_pitch_rad, e.right_roll_rad);
  camera.x_m = rectified.baseline_m * e.baseline_ratio;
  return camera;
}

double overhang_px(const StereoCamera& rectified, const RawCamera& raw) {
  double farthest_px = 0.0;
  const auto beyond = [&](double at_px, int size_px) {
    farthest_px = std::max({farthest_px, -0.5 - at_px, at_px - (size_px - 0.5)});
  };
  for_sample_pixels(rectified.width_px, rectified.height_px, [&](int u, int v) {
    const Eigen::Vector3d ray((u - rectified.cx_px) / rectified.fx_px,
                              (v - rectified.cy_px) / rectified.fy_px, 1.0);
    const Eigen::Vector3d x = raw.R_rectified_raw.transpose() * ray;
    const Eigen::Vector2d direction = x.head<2>() / std::max(x.z(), kSteepest_z);
    if (x.z() < kSteepest_z || !is_upright(derivative(raw.distortion, direction))) {
      farthest_px = std::numeric_limits<double>::infinity();
      return;
    }
    const Eigen::Vector2d p = distorted(raw.distortion, direction);
    beyond(raw.K(0, 0) * p.x() + raw.K(0, 2), raw.width_px);
    beyond(raw.K(1, 1) * p.y() + raw.K(1, 2), raw.height_px);
  });
  return farthest_px;
}

bool is_invertible(const RawCamera& raw) {
  bool all = true;
  for_sample_pixels(raw.width_px, raw.height_px, [&](int u, int v) {
    const Eigen::Vector2d image((u - raw.K(0, 2)) / raw.K(0, 0), (v - raw.K(1, 2)) / raw.K(1, 1));
    all = all && undistorted(raw.distortion, image).has_value();
  });
  return all;
}

}  // namespace egomod::sim
