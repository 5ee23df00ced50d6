// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace egomod {

// Rectified stereo camera: both images share one K and their rows. Left camera frame: x right,
// y down, z forward; pixel centres on integers. Disparity = u_left - u_right = fx * baseline / z >
// 0.
struct StereoCamera {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double baseline_m = 0.0;
  int width_px = 0;
  int height_px = 0;

  bool operator==(const StereoCamera&) const = default;
};

// One raw camera: pinhole with radial-tangential distortion (k1 k2 p1 p2 k3, as OpenCV and KITTI).
struct RawCamera {
  int width_px = 0;
  int height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  std::array<double, 5> distortion{};
  Eigen::Matrix3d R_rectified_raw =
      Eigen::Matrix3d::Identity();  // x_rect = R_rectified_raw * x_raw

  bool operator==(const RawCamera&) const = default;
};

// The body frame of REP 103 (x forward, y left, z up) of a rig whose file gives no T_body_camera:
// the axis permutation with zero translation.
[[nodiscard]] Eigen::Isometry3d default_T_body_camera();

// Everything known about a rig. When `images_are_raw`, capture rectifies with `left` and `right`
// before a pair leaves it; every later stage sees `camera` only.
struct Calibration {
  StereoCamera camera;
  bool images_are_raw = false;
  RawCamera left;
  RawCamera right;
  // x_right = R_right_left * x_left + t_right_left_m, both raw camera frames.
  Eigen::Matrix3d R_right_left = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_right_left_m = Eigen::Vector3d::Zero();
  Eigen::Isometry3d T_body_camera = default_T_body_camera();
};

[[nodiscard]] bool operator==(const Calibration& a, const Calibration& b);

}  // namespace egomod
