// SPDX-License-Identifier: Apache-2.0
#include "synthetic_world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "egomod/core/geometry.hpp"
#include "scenes.hpp"

namespace egomod::test_support {
namespace {

constexpr double kCentroidTolerance_px = 0.05;
constexpr double kSpotPitch_m = 0.25;
constexpr double kSpotSigma_m = 0.012;

Scene wall_of_spots() {
  Scene scene;
  const auto texture =
      add_texture(scene, 4.0, 2.0, 0.004, gaussian_spots(kSpotPitch_m, kSpotSigma_m));
  Body wall;
  wall.patches.push_back({{-2, -1, 2.5}, {4, 0, 0.3}, {0, 2, 0}, texture, 1.0});
  scene.bodies.push_back(std::move(wall));
  return scene;
}

Eigen::Vector3d spot(const Patch& patch, int i, int j) {
  return patch.corner_m + patch.edge_s_m * ((i + 0.5) * kSpotPitch_m / 4.0) +
         patch.edge_t_m * ((j + 0.5) * kSpotPitch_m / 2.0);
}

// Centroid of the darkness below the wall's 200 around (u, v).
Eigen::Vector2d centroid(const Image& image, double u, double v) {
  constexpr int kRadius_px = 9;
  const int cu = static_cast<int>(std::lround(u));
  const int cv = static_cast<int>(std::lround(v));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = cv - kRadius_px; y <= cv + kRadius_px; ++y) {
    for (int x = cu - kRadius_px; x <= cu + kRadius_px; ++x) {
      const double darkness = 200.0 - image.row(y)[x];
      sum += darkness * Eigen::Vector3d(x, y, 1.0);
    }
  }
  return sum.head<2>() / sum[2];
}

bool well_inside(const StereoCamera& camera, const Eigen::Vector3d& uvd_px) {
  const double u_right = uvd_px[0] - uvd_px[2];
  return u_right > 20 && uvd_px[0] < camera.width_px - 20 && uvd_px[1] > 20 &&
         uvd_px[1] < camera.height_px - 20;
}

std::uint64_t checksum(const Image& image) {
  std::uint64_t sum = 0;
  for (int v = 0; v < image.height_px(); ++v) {
    for (int u = 0; u < image.width_px(); ++u) sum = sum * 1099511628211ULL + image.row(v)[u];
  }
  return sum;
}

TEST(SyntheticWorld, SpotsAppearWhereTheyProjectInBothImages) {
  Scene scene = wall_of_spots();
  scene.T_world_camera = arc({0.05, 0, 0}, 0.0, 0.5, 0.2);
  const SyntheticWorld world(std::move(scene), kinect_pair());
  Image left;
  Image right;
  int spots = 0;
  for (const double t_s : {0.0, 0.7}) {
    world.render(t_s, left, right);
    const Eigen::Isometry3d T_camera_world = world.scene().T_world_camera(t_s).inverse();
    for (int i = 0; i < 16; ++i) {
      for (int j = 0; j < 8; ++j) {
        const Eigen::Vector3d P = T_camera_world * spot(world.scene().bodies[0].patches[0], i, j);
        const Eigen::Vector3d expected = project(world.camera(), P);
        if (!well_inside(world.camera(), expected)) continue;
        const Eigen::Vector2d in_left = centroid(left, expected[0], expected[1]);
        const Eigen::Vector2d in_right = centroid(right, expected[0] - expected[2], expected[1]);
        EXPECT_NEAR(in_left.x(), expected[0], kCentroidTolerance_px);
        EXPECT_NEAR(in_left.y(), expected[1], kCentroidTolerance_px);
        EXPECT_NEAR(in_right.x(), expected[0] - expected[2], kCentroidTolerance_px);
        EXPECT_NEAR(in_right.y(), expected[1], kCentroidTolerance_px);
        ++spots;
      }
    }
  }
  EXPECT_GT(spots, 50);
}

TEST(SyntheticWorld, DepthIsThatOfThePlaneBehindThePixel) {
  const SyntheticWorld world(wall_of_spots(), kinect_pair(320));
  const StereoCamera& camera = world.camera();
  const PixelTruth truth = world.pixels(0.0);
  const int u = 200;
  const int v = 90;
  // The wall is z = 2.5 + 0.075 (x + 2).
  const double x_over_z = (u - camera.cx_px) / camera.fx_px;
  const double expected_m = 2.65 / (1.0 - 0.075 * x_over_z);
  EXPECT_NEAR(truth.depth_m[static_cast<std::size_t>(v * camera.width_px + u)], expected_m, 1e-4);
}

TEST(SyntheticWorld, SameTimeGivesTheSameBytesAndOtherSeedsOtherNoise) {
  const StereoCamera camera = kinect_pair(160);
  const SyntheticWorld world(crossing_robot(), camera, {.noise_sigma = 2.0, .seed = 1});
  const SyntheticWorld reseeded(crossing_robot(), camera, {.noise_sigma = 2.0, .seed = 2});
  Image a;
  Image b;
  Image c;
  Image right;
  world.render(0.5, a, right);
  world.render(0.5, b, right);
  reseeded.render(0.5, c, right);
  EXPECT_EQ(checksum(a), checksum(b));
  EXPECT_NE(checksum(a), checksum(c));
  EXPECT_NE(checksum(a), checksum(right));
}

TEST(SyntheticWorld, NoiseHasTheSigmaThatWasAskedFor) {
  Scene scene;
  const auto grey = add_texture(scene, 1.0, 1.0, 0.02, [](double, double) { return 128.0; });
  Body wall;
  wall.patches.push_back({{-9, -9, 2}, {18, 0, 0}, {0, 18, 0}, grey, 1.0});
  scene.bodies.push_back(std::move(wall));
  const SyntheticWorld world(std::move(scene), kinect_pair(320), {.noise_sigma = 3.0});
  Image left;
  Image right;
  world.render(0.0, left, right);
  double sum = 0.0;
  double squares = 0.0;
  for (int v = 0; v < left.height_px(); ++v) {
    for (int u = 0; u < left.width_px(); ++u) {
      const double deviation = left.row(v)[u] - 128.0;
      sum += deviation;
      squares += deviation * deviation;
    }
  }
  const double count = static_cast<double>(left.width_px()) * left.height_px();
  EXPECT_NEAR(sum / count, 0.0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(9.0 + 1.0 / 12.0), 0.05);
}

TEST(SyntheticWorld, ObjectsCarryTheirVelocityRectangleAndPixels) {
  const SyntheticWorld world(crossing_robot(), kinect_pair());
  const auto objects = world.objects(2.0);
  ASSERT_EQ(objects.size(), 1U);
  const ObjectTruth& robot = objects.front();
  EXPECT_TRUE(robot.moving);
  EXPECT_NEAR((robot.velocity_mps - Eigen::Vector3d(0.6, 0, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(robot.angular_velocity_radps.norm(), 0.0, 1e-6);
  // It drives to the right and shows its flank, 0.5 m from x = -0.65 m on at z = 3.4 - 0.8 - 0.22
  // m; at the right also its front, whose far edge, 0.44 m deeper, is the rightmost.
  EXPECT_NEAR(robot.u_min_px, 319.5 - 525.0 * 0.65 / 2.38, 1.0);
  EXPECT_NEAR(robot.u_max_px, 319.5 - 525.0 * 0.15 / 2.82, 1.0);
  EXPECT_GT(robot.visible_px, 10000);
  EXPECT_NEAR(robot.occluded_fraction, 0.0, 1e-9);
  EXPECT_NEAR(robot.surface_centroid_m.x(), -1.6 + 1.2, 0.03);
}

TEST(SyntheticWorld, TurningObjectMovesFasterOnItsOuterSide) {
  Scene scene = furnished_room();
  Body body = robot(scene, 1);
  body.T_world_body = steady({.start_m = {0, kFloor_m, 3.0}, .yaw_rate_radps = 0.5});
  scene.bodies.push_back(std::move(body));
  const auto objects = SyntheticWorld(std::move(scene), kinect_pair(320)).objects(0.0);
  const ObjectTruth& turning = objects.front();
  const Eigen::Vector3d omega(0, 0.5, 0);
  const Eigen::Vector3d lever = turning.surface_centroid_m - Eigen::Vector3d(0, kFloor_m, 3.0);
  EXPECT_NEAR((turning.angular_velocity_radps - omega).norm(), 0.0, 1e-6);
  EXPECT_NEAR((turning.velocity_mps - omega.cross(lever)).norm(), 0.0, 1e-6);
}

TEST(SyntheticWorld, RigPoseIsRelativeToItsStart) {
  const SyntheticWorld world(static_room(), kinect_pair(160));
  EXPECT_TRUE(world.T_first_current(0.0).isApprox(Eigen::Isometry3d::Identity(), 1e-12));
  EXPECT_NEAR(world.T_first_current(6.0).translation().z(), 3.0, 1e-9);
}

}  // namespace
}  // namespace egomod::test_support
