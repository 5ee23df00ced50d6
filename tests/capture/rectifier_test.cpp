// SPDX-License-Identifier: Apache-2.0
#include "capture/rectifier.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "capture/calibration_check.hpp"
#include "capture/lens.hpp"
#include "capture/rectify_kernel.hpp"
#include "capture/stereo_rectify.hpp"
#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kInverse_px = 1e-8;
constexpr double kRows_px = 1e-9;
constexpr double kGreyOfInterpolation = 1.5;  // 1/128 px of slope, rounding twice
constexpr int kGreyAgainstOpenCv = 1;

RawCamera example_camera(double shift_px) {
  RawCamera camera;
  camera.width_px = 320;
  camera.height_px = 240;
  camera.K << 230.0 + shift_px, 0, 158.0 + shift_px, 0, 229.0, 121.0 - shift_px, 0, 0, 1;
  camera.distortion = {-0.28, 0.074, 0.0002, -0.0003, 0.001};
  return camera;
}

Calibration example_rig() {
  Calibration rig;
  rig.left = example_camera(0.0);
  rig.right = example_camera(1.5);
  rig.R_right_left = so3_exp({0.01, -0.03, 0.008});
  rig.t_right_left_m = {-0.11, 0.002, -0.003};
  choose_rectification(rig, "rig");
  return rig;
}

double smooth_grey(double u, double v) {
  return 127.0 + 60.0 * std::sin(0.11 * u + 0.3) + 50.0 * std::cos(0.13 * v + 0.05 * u);
}

Image smooth_image(int width_px, int height_px) {
  Image image(width_px, height_px);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      image.row(v)[u] = static_cast<std::uint8_t>(std::lround(smooth_grey(u, v)));
    }
  }
  return image;
}

cv::Matx33d to_cv(const Eigen::Matrix3d& M) {
  return {M(0, 0), M(0, 1), M(0, 2), M(1, 0), M(1, 1), M(1, 2), M(2, 0), M(2, 1), M(2, 2)};
}

cv::Matx33d camera_matrix(const StereoCamera& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

cv::Mat distortion(const RawCamera& camera) { return cv::Mat(camera.distortion, true).t(); }

TEST(RectifyKernel, AGroupIsBitEqualToItsPixelsOneByOne) {
  constexpr std::size_t kStride = 40;
  std::mt19937 random(7);
  const auto below = [&](int limit) {
    return static_cast<int>(random() % static_cast<unsigned>(limit));
  };
  std::array<std::uint8_t, kStride * RectifyGroup::kRows> raw{};
  for (int run = 0; run < 2000; ++run) {
    for (std::uint8_t& pixel : raw) pixel = static_cast<std::uint8_t>(below(256));
    RectifyGroup group;
    std::array<RectifyFraction, RectifyGroup::kPixels> fractions;
    std::array<std::uint8_t, RectifyGroup::kPixels> expected{};
    for (std::size_t k = 0; k < RectifyGroup::kPixels; ++k) {
      group.column[k] = static_cast<std::uint8_t>(below(RectifyGroup::kColumns - 1));
      group.is_lower[k] = below(2) == 0 ? 0 : 255;
      fractions[k] = {static_cast<std::uint8_t>(below(kRectifyOne + 1)),
                      static_cast<std::uint8_t>(below(kRectifyOne + 1))};
      const std::size_t row = group.is_lower[k] != 0 ? kStride : 0;
      expected[k] = rectified_pixel(raw.data() + row + group.column[k], kStride, fractions[k]);
    }
    std::array<std::uint8_t, RectifyGroup::kPixels> found{};
    rectify_group(raw.data(), kStride, group, fractions.data(), found.data());
    ASSERT_EQ(found, expected) << run;
  }
}

TEST(Lens, DistortsAsOpenCvAndUndoesItself) {
  const RawCamera camera = example_camera(0.0);
  const Lens lens(camera);
  for (double x = -0.6; x <= 0.6; x += 0.15) {
    for (double y = -0.45; y <= 0.45; y += 0.15) {
      const Eigen::Vector2d pixel = lens.pixel({x, y});
      std::vector<cv::Point2d> projected;
      cv::projectPoints(std::vector<cv::Point3d>{{x, y, 1.0}}, cv::Vec3d(), cv::Vec3d(),
                        to_cv(camera.K), distortion(camera), projected);
      EXPECT_NEAR(pixel.x(), projected[0].x, kInverse_px);
      EXPECT_NEAR(pixel.y(), projected[0].y, kInverse_px);
      EXPECT_LT((lens.normalised(pixel) - Eigen::Vector2d(x, y)).norm(), kInverse_px);
    }
  }
}

TEST(Rectifier, AgreesWithOpenCvWithinOneGrey) {
  const Calibration rig = example_rig();
  const Image raw = smooth_image(320, 240);
  for (const RawCamera* camera : {&rig.left, &rig.right}) {
    Image rectified;
    Rectifier(*camera, rig.camera).apply(raw, rectified);
    cv::Mat map_u;
    cv::Mat map_v;
    cv::Mat oracle;
    cv::initUndistortRectifyMap(to_cv(camera->K), distortion(*camera),
                                to_cv(camera->R_rectified_raw), camera_matrix(rig.camera),
                                {rig.camera.width_px, rig.camera.height_px}, CV_32FC1, map_u,
                                map_v);
    const cv::Mat source(240, 320, CV_8UC1, const_cast<std::uint8_t*>(raw.row(0)),
                         static_cast<std::size_t>(raw.stride_bytes()));
    cv::remap(source, oracle, map_u, map_v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    for (int v = 0; v < oracle.rows; ++v) {
      for (int u = 0; u < oracle.cols; ++u) {
        ASSERT_NEAR(rectified.row(v)[u], oracle.at<std::uint8_t>(v, u), kGreyAgainstOpenCv);
      }
    }
  }
}

TEST(Rectifier, PutsEachPointOfTheSceneWhereTheRectifiedCameraSeesIt) {
  const Calibration rig = example_rig();
  const Image raw = smooth_image(320, 240);
  Image rectified;
  Rectifier(rig.left, rig.camera).apply(raw, rectified);
  const Lens lens(rig.left);
  for (int v = 2; v < 238; v += 7) {
    for (int u = 2; u < 318; u += 7) {
      const Eigen::Vector3d ray((u - rig.camera.cx_px) / rig.camera.fx_px,
                                (v - rig.camera.cy_px) / rig.camera.fy_px, 1.0);
      const Eigen::Vector3d x = rig.left.R_rectified_raw.transpose() * ray;
      const Eigen::Vector2d pixel = lens.pixel(x.hnormalized());
      ASSERT_NEAR(rectified.row(v)[u], smooth_grey(pixel.x(), pixel.y()), kGreyOfInterpolation);
    }
  }
}

TEST(Rectifier, PassesAPerfectCameraUnchangedToTheLastRowAndColumn) {
  StereoCamera camera{200, 200, 31.5, 23.5, 0.1, 64, 48};
  RawCamera raw;
  raw.width_px = 64;
  raw.height_px = 48;
  raw.K << 200, 0, 31.5, 0, 200, 23.5, 0, 0, 1;
  const Image image = smooth_image(64, 48);
  Image rectified;
  Rectifier(raw, camera).apply(image, rectified);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) ASSERT_EQ(rectified.row(v)[u], image.row(v)[u]);
  }
}

TEST(Rectifier, RepeatsTheBorderOutsideOfTheRawImage) {
  StereoCamera camera{200, 200, 41.5, 23.5, 0.1, 64, 48};
  RawCamera raw;
  raw.width_px = 64;
  raw.height_px = 48;
  raw.K << 200, 0, 31.5, 0, 200, 23.5, 0, 0, 1;
  const Image image = smooth_image(64, 48);
  Image rectified;
  Rectifier(raw, camera).apply(image, rectified);
  EXPECT_EQ(rectified.row(20)[0], image.row(20)[0]);
  EXPECT_EQ(rectified.row(20)[9], image.row(20)[0]);
  EXPECT_EQ(rectified.row(20)[12], image.row(20)[2]);
}

TEST(ChooseRectification, LaysPointsIntoTheSameRowWithTheDisparityOfTheirDepth) {
  const Calibration rig = example_rig();
  EXPECT_EQ(fault_of(rig), "");
  EXPECT_NEAR(rig.camera.baseline_m, rig.t_right_left_m.norm(), 1e-12);
  for (const Eigen::Vector3d& x_left :
       {Eigen::Vector3d(0.2, -0.1, 1.5), Eigen::Vector3d(-0.7, 0.5, 3.0)}) {
    const Eigen::Vector3d x_right = rig.R_right_left * x_left + rig.t_right_left_m;
    const Eigen::Vector3d l = rig.left.R_rectified_raw * x_left;
    const Eigen::Vector3d r = rig.right.R_rectified_raw * x_right;
    EXPECT_NEAR(rig.camera.fy_px * (l.y() / l.z() - r.y() / r.z()), 0.0, kRows_px);
    EXPECT_NEAR(rig.camera.fx_px * (l.x() / l.z() - r.x() / r.z()),
                rig.camera.fx_px * rig.camera.baseline_m / l.z(), kRows_px);
  }
}

TEST(ChooseRectification, ShowsOnlyWhatBothCamerasSaw) {
  const Calibration rig = example_rig();
  for (const RawCamera* raw : {&rig.left, &rig.right}) {
    for (const int u : {0, 160, 319}) {
      for (const int v : {0, 120, 239}) {
        const Eigen::Vector3d ray((u - rig.camera.cx_px) / rig.camera.fx_px,
                                  (v - rig.camera.cy_px) / rig.camera.fy_px, 1.0);
        const Eigen::Vector2d pixel =
            Lens(*raw).pixel((raw->R_rectified_raw.transpose() * ray).hnormalized());
        EXPECT_GT(pixel.x(), -0.5);
        EXPECT_GT(pixel.y(), -0.5);
        EXPECT_LT(pixel.x(), 319.5);
        EXPECT_LT(pixel.y(), 239.5);
      }
    }
  }
}

}  // namespace
}  // namespace egomod
