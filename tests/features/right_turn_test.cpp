// SPDX-License-Identifier: Apache-2.0
#include "right_turn.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "egomod/core/geometry.hpp"
#include "test_camera.hpp"

namespace egomod {
namespace {

constexpr double kInterval_s = 1.0 / 30;
constexpr int kPairs = 20;
constexpr double kNoise_px = 0.1;
constexpr double kTolerance_rad = 4e-4;

// What a right camera shows that has turned, and whose lens is off its axis by p2.
void show(RightTurn& learner, const Eigen::Vector3d& turn_rad, double p2 = 0.0) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(20.0, 620.0), v(20.0, 460.0), d(5.0, 60.0);
  std::normal_distribution<double> noise(0.0, kNoise_px);
  for (int pair = 0; pair < kPairs; ++pair) {
    std::vector<RightTurn::Row> rows;
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector2d right(u(random), v(random));
      const double x = (right.x() - kCamera.cx_px) / kCamera.fx_px;
      const double y = (right.y() - kCamera.cy_px) / kCamera.fy_px;
      const Eigen::Vector3d ray = so3_exp(turn_rad) * Eigen::Vector3d(x, y, 1.0);
      const double seen = kCamera.fy_px * (ray.y() / ray.z() + 2 * p2 * x * y) + kCamera.cy_px;
      rows.push_back({right, d(random), seen - right.y() + noise(random), kNoise_px * kNoise_px});
    }
    learner.learn(kCamera, rows, kInterval_s);
  }
}

RightTurn fresh() {
  RightTurn learner(100);
  learner.forget();
  return learner;
}

TEST(RightTurn, finds_how_the_camera_has_turned) {
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d truth = sign * Eigen::Vector3d(5e-3, -4e-3, -6e-3);
    RightTurn learner = fresh();
    show(learner, truth);
    ASSERT_TRUE(learner.is_off());
    EXPECT_TRUE(learner.take_change());
    EXPECT_FALSE(learner.take_change());
    EXPECT_NEAR(learner.turn_rad().x(), truth.x(), kTolerance_rad);
    EXPECT_NEAR(learner.turn_rad().z(), truth.z(), kTolerance_rad);
    EXPECT_LT(std::abs(learner.turn_rad().y() - truth.y()), learner.yaw_sigma_rad());
  }
}

TEST(RightTurn, leaves_good_calibrations_alone) {
  RightTurn learner = fresh();
  show(learner, {4e-4, 3e-4, -2e-4});
  EXPECT_FALSE(learner.is_off());
  EXPECT_TRUE(learner.turn_rad().isZero(0.0));
  EXPECT_EQ(learner.yaw_sigma_rad(), 0.0);
  EXPECT_FALSE(learner.take_change());
}

// As on the city drives, where the rows feign a yaw of 8 mrad.
TEST(RightTurn, does_not_take_a_lens_off_its_axis_for_yaw) {
  RightTurn learner = fresh();
  show(learner, Eigen::Vector3d::Zero(), 4e-3);
  EXPECT_FALSE(learner.is_off());
  EXPECT_TRUE(learner.turn_rad().isZero(0.0));
}

TEST(RightTurn, forgets) {
  RightTurn learner = fresh();
  show(learner, {5e-3, 0.0, 5e-3});
  learner.forget();
  EXPECT_FALSE(learner.is_off());
  EXPECT_TRUE(learner.turn_rad().isZero(0.0));
}

}  // namespace
}  // namespace egomod
