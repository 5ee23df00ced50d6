// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/trails.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <numbers>

namespace egomod {
namespace {

using namespace std::chrono_literals;

constexpr double kTinyError = 1e-9;
const Eigen::Matrix3d kSameAxes = Eigen::Matrix3d::Identity();

// One point, seen each 33 ms.
struct Walk {
  Trails trails;
  Nanoseconds now{0};
  Eigen::Vector3d position_m{1.0, 0.0, 5.0};

  void step(const Eigen::Vector3d& velocity_mps, bool anew = false) {
    now += 33ms;
    position_m += to_seconds(33ms) * velocity_mps;
    trails.begin(now, anew);
    trails.add(3, position_m, false);
  }
};

TEST(Trails, EachWindowHasTheVelocityOfASteadyPoint) {
  const Eigen::Vector3d velocity_mps{0.4, -0.1, 0.2};
  Walk walk;
  for (int k = 0; k < 40; ++k) walk.step(velocity_mps);
  const RecentVelocities recent = walk.trails.velocities(3, kSameAxes);
  ASSERT_EQ(recent.count, kRecentPairs.size());
  for (std::size_t k = 0; k < recent.count; ++k) {
    EXPECT_LT((recent.windows[k].velocity_mps - velocity_mps).norm(), kTinyError);
    EXPECT_NEAR(recent.windows[k].span_s, 0.033 * static_cast<double>(kRecentPairs[k] - 1),
                kTinyError);
  }
  // Three equidistant points: 2 sigma^2 / (2 dt)^2.
  EXPECT_NEAR(recent.windows[0].gain_hz2 * 2.0 * 0.033 * 0.033, 1.0, kTinyError);
}

TEST(Trails, AWindowKnowsNothingOfWhatWasBeforeIt) {
  Walk walk;
  for (int k = 0; k < 20; ++k) walk.step(Eigen::Vector3d::Zero());
  for (int k = 0; k < 3; ++k) walk.step({0.0, 0.0, 0.4});
  const RecentVelocities recent = walk.trails.velocities(3, kSameAxes);
  ASSERT_GE(recent.count, 3U);
  EXPECT_NEAR(recent.windows[0].velocity_mps.z(), 0.4, kTinyError);
  EXPECT_LT(recent.windows[2].velocity_mps.z(), 0.35);
}

TEST(Trails, TurnsVelocitiesToTheAxesAskedFor) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Walk walk;
  for (int k = 0; k < 5; ++k) walk.step({0.0, 0.0, 0.4});
  EXPECT_NEAR(walk.trails.velocities(3, R).windows[0].velocity_mps.x(), 0.4, kTinyError);
}

TEST(Trails, StartsAnewAfterAGapAResetOrAnotherPoint) {
  Walk walk;
  const auto windows = [&] { return walk.trails.velocities(3, kSameAxes).count; };
  for (int k = 0; k < 8; ++k) walk.step(Eigen::Vector3d::Zero());
  EXPECT_GT(windows(), 2U);
  walk.trails.begin(walk.now += 33ms, false);
  EXPECT_EQ(windows(), 0U);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(windows(), 0U);
    walk.step(Eigen::Vector3d::Zero());
  }
  EXPECT_EQ(windows(), 1U);
  walk.step(Eigen::Vector3d::Zero(), true);
  EXPECT_EQ(windows(), 0U);
  for (int k = 0; k < 3; ++k) walk.step(Eigen::Vector3d::Zero());
  EXPECT_GT(windows(), 0U);
  walk.trails.begin(walk.now += 33ms, false);
  walk.trails.add(3, walk.position_m, true);
  EXPECT_EQ(windows(), 0U);
}

TEST(Trails, WindowsAtALowRateAreShortEnough) {
  Trails trails;
  Nanoseconds now{0};
  for (int k = 0; k < 20; ++k) {
    trails.begin(now += 200ms, false);
    trails.add(0, Eigen::Vector3d::Zero(), false);
  }
  EXPECT_EQ(trails.velocities(0, kSameAxes).count, 1U);
}

}  // namespace
}  // namespace egomod
