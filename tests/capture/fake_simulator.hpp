// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "egomod/core/calibration.hpp"

// What the fake of egomod-sim sends, unless it misbehaves: left images as grey as their number,
// right ones by 100 more.
namespace egomod::fake_simulator {

inline constexpr int kPairs = 6;
inline constexpr int kWidth_px = 40;
inline constexpr int kHeight_px = 30;
inline constexpr std::int64_t kSkew_us = 2500;
inline constexpr double kWheelStep_m = 0.0625;  // a pair, in the world "has-wheels"

inline std::int64_t exposure_us(int pair) { return 33'333 * static_cast<std::int64_t>(pair); }

// Raw images, with every parameter of its own.
inline Calibration calibration() {
  Calibration c;
  c.camera = {.fx_px = 36.5,
              .fy_px = 36.25,
              .cx_px = 19.5,
              .cy_px = 14.75,
              .baseline_m = 0.375,
              .width_px = kWidth_px,
              .height_px = kHeight_px};
  c.images_are_raw = true;
  c.left = {.width_px = kWidth_px, .height_px = kHeight_px};
  c.left.K << 36.0, 0.0, 19.0, 0.0, 36.0, 15.0, 0.0, 0.0, 1.0;
  c.left.distortion = {0.01, -0.002, 0.001, 0.0005, 0.0001};
  c.right = c.left;
  c.right.K(0, 0) = 37.0;
  c.right.distortion[0] = -0.01;
  c.R_right_left = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
  c.right.R_rectified_raw = c.R_right_left.transpose();
  c.t_right_left_m = {-0.375, 0.001, 0.002};
  c.T_body_camera.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  return c;
}

}  // namespace egomod::fake_simulator
