// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "egomod/core/calibration.hpp"

namespace egomod::sim {

// k1 k2 p1 p2 k3 of D. C. Brown, Decentering distortion of lenses (1966), in OpenCV's order. The
// simulator has a lens model of its own, so that it can prove the daemon's.
using Distortion = std::array<double, 5>;

// Where the lens puts the direction (x/z, y/z).
[[nodiscard]] Eigen::Vector2d distorted(const Distortion& lens, const Eigen::Vector2d& direction);
// Its inverse. Nothing where the lens model folds back: such a point comes from no one direction.
[[nodiscard]] std::optional<Eigen::Vector2d> undistorted(const Distortion& lens,
                                                         const Eigen::Vector2d& image);

// One camera as it is built into the rig.
struct CameraBuild {
  double focal_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  Distortion distortion{};
  // Of the camera in the rectified frame: right, down and clockwise are positive.
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

// By how much the right camera differs from what the calibration that is written says of it.
struct CalibrationError {
  double right_yaw_rad = 0.0;
  double right_pitch_rad = 0.0;
  double right_roll_rad = 0.0;
  double right_focal_ratio = 1.0;
  double baseline_ratio = 1.0;
};

// Raw cameras where the images are not rectified. Sizes are those of the rectified images.
struct Optics {
  bool images_are_raw = false;
  CameraBuild left;
  CameraBuild right;
  CalibrationError error;
};

// What files and messages say of the rig.
[[nodiscard]] Calibration written_calibration(const StereoCamera& rectified, const Optics& optics);

// A camera as it really is.
struct RealCamera {
  RawCamera raw;
  double x_m = 0.0;  // on the baseline, from the left camera
};
enum class Eye { kLeft, kRight };
[[nodiscard]] RealCamera real_camera(const StereoCamera& rectified, const Optics& optics, Eye eye);

// The farthest that a pixel of the rectified image lies outside of the raw one, pixels; infinite
// where the lens shows it nowhere.
[[nodiscard]] double overhang_px(const StereoCamera& rectified, const RawCamera& raw);
// Whether each pixel of the raw image comes from one direction.
[[nodiscard]] bool is_invertible(const RawCamera& raw);

}  // namespace egomod::sim
