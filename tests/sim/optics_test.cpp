// SPDX-License-Identifier: Apache-2.0
#include "optics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace egomod::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kExact = 1e-10;
constexpr double kRadPerDeg = M_PI / 180.0;

StereoCamera rectified() {
  return {.fx_px = 545.0,
          .fy_px = 545.0,
          .cx_px = 319.5,
          .cy_px = 239.5,
          .baseline_m = 0.375,
          .width_px = 640,
          .height_px = 480};
}

Optics bent() {
  Optics optics;
  optics.images_are_raw = true;
  optics.left = {.focal_px = 520.0, .cx_px = 321.0, .cy_px = 238.0, .pitch_rad = 0.01};
  optics.right = {.focal_px = 518.0,
                  .cx_px = 317.0,
                  .cy_px = 242.0,
                  .distortion = {-0.1, 0.02, 0.001, 0.0, 0.0},
                  .yaw_rad = 0.02,
                  .roll_rad = -0.01};
  return optics;
}

TEST(Optics, ALensBendsAsItsCoefficientsSay) {
  // By hand: r^2 = 0.25, radial 1 + 0.25 k1 + 0.0625 k2 + 0.015625 k3.
  const Vector2d out = distorted({0.4, -0.8, 0.01, 0.02, 1.6}, {0.3, 0.4});
  const double radial = 1.0 + 0.1 - 0.05 + 0.025;
  EXPECT_NEAR(out.x(), 0.3 * radial + 2 * 0.01 * 0.12 + 0.02 * (0.25 + 2 * 0.09), kExact);
  EXPECT_NEAR(out.y(), 0.4 * radial + 0.01 * (0.25 + 2 * 0.16) + 2 * 0.02 * 0.12, kExact);
}

TEST(Optics, UnbendingInvertsBending) {
  const Distortion lens{-0.22, 0.05, 0.002, -0.003, 0.004};
  for (const Vector2d& direction : {Vector2d(0.6, -0.45), Vector2d(-0.3, 0.1), Vector2d(0, 0)}) {
    const auto back = undistorted(lens, distorted(lens, direction));
    ASSERT_TRUE(back);
    EXPECT_NEAR((*back - direction).norm(), 0.0, kExact);
  }
}

TEST(Optics, ALensThatFoldsBackIsNotInvertible) {
  // r (1 - 0.6 r^2) never exceeds 0.497.
  EXPECT_FALSE(undistorted({-0.6, 0, 0, 0, 0}, {0.55, 0.0}));
  RawCamera raw;
  raw.width_px = 640;
  raw.height_px = 480;
  raw.K << 520, 0, 319.5, 0, 520, 239.5, 0, 0, 1;
  EXPECT_TRUE(is_invertible(raw));
  raw.distortion = {-0.6, 0, 0, 0, 0};
  EXPECT_FALSE(is_invertible(raw));
}

TEST(Optics, TheWrittenCalibrationRelatesBothRawCameras) {
  const Calibration c = written_calibration(rectified(), bent());
  ASSERT_TRUE(c.images_are_raw);
  const Vector3d P_rectified(0.3, -0.2, 2.0);
  const Vector3d P_left = c.left.R_rectified_raw.transpose() * P_rectified;
  const Vector3d P_right =
      c.right.R_rectified_raw.transpose() * (P_rectified - Vector3d(0.375, 0, 0));
  EXPECT_NEAR((c.R_right_left * P_left + c.t_right_left_m - P_right).norm(), 0.0, kExact);
}

TEST(Optics, ARightTurnedCameraSeesThingsFurtherLeft) {
  const Calibration c = written_calibration(rectified(), bent());
  const Vector3d ahead = c.right.R_rectified_raw.transpose() * Vector3d(0, 0, 1);
  EXPECT_LT(ahead.x(), -0.015);
}

TEST(Optics, CalibrationErrorsChangeTheRightCameraOnlyAndNotWhatIsWritten) {
  Optics wrong = bent();
  wrong.error = {
      .right_yaw_rad = 0.5 * kRadPerDeg, .right_focal_ratio = 1.01, .baseline_ratio = 0.98};
  EXPECT_EQ(written_calibration(rectified(), wrong), written_calibration(rectified(), bent()));
  EXPECT_EQ(real_camera(rectified(), wrong, Eye::kLeft).raw,
            written_calibration(rectified(), bent()).left);
  const RealCamera right = real_camera(rectified(), wrong, Eye::kRight);
  EXPECT_NEAR(right.x_m, 0.98 * 0.375, kExact);
  EXPECT_NEAR(right.raw.K(0, 0), 1.01 * 518.0, kExact);
  EXPECT_NEAR(right.raw.K(0, 2), 317.0, kExact);
  const Eigen::AngleAxisd off(
      written_calibration(rectified(), bent()).right.R_rectified_raw.transpose() *
      right.raw.R_rectified_raw);
  EXPECT_NEAR(off.angle(), 0.5 * kRadPerDeg, kExact);
}

TEST(Optics, TellsHowFarTheRectifiedImageReachesBeyondTheRawOne) {
  RawCamera raw = real_camera(rectified(), bent(), Eye::kLeft).raw;
  raw.R_rectified_raw.setIdentity();
  EXPECT_EQ(overhang_px(rectified(), raw), 0.0);
  raw.K.topLeftCorner<2, 2>() *= 560.0 / 520.0;
  // The corner at 319.5 px / 545 px from the axis lies 560 / 545 times as far out.
  EXPECT_NEAR(overhang_px(rectified(), raw), 319.5 * 560.0 / 545.0 + 321.0 - 639.5, 1e-6);
}

}  // namespace
}  // namespace egomod::sim
