// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace egomod::sim {
namespace {

constexpr double kExact = 1e-9;

TEST(Motion, AcceleratesAsTheThesisTarget) {
  const SpeedProfile profile{.speed_mps = 0.4, .acceleration_mps2 = 0.015};
  EXPECT_NEAR(distance_m(profile, 10.0), 4.0 + 0.75, kExact);
}

TEST(Motion, BrakesToRestAndStays) {
  const SpeedProfile profile{.speed_mps = 1.0, .acceleration_mps2 = -0.5};
  EXPECT_NEAR(distance_m(profile, 2.0), 1.0, kExact);
  EXPECT_NEAR(distance_m(profile, 9.0), 1.0, kExact);
}

TEST(Motion, StopsAndGoesWithRamps) {
  const SpeedProfile profile{.speed_mps = 1.0, .go_s = 2.0, .pause_s = 1.0, .ramp_s = 0.5};
  EXPECT_NEAR(distance_m(profile, 2.0), 1.5, kExact);
  EXPECT_NEAR(distance_m(profile, 2.9), 1.5, kExact);
  EXPECT_NEAR(distance_m(profile, 5.0), 3.0, kExact);
}

TEST(Motion, TurnsRightOnACircle) {
  const Path circle = endless_path({}, 0.5);
  const PlanPose quarter = pose_at(circle, M_PI);
  EXPECT_NEAR(quarter.x_m, 2.0, kExact);
  EXPECT_NEAR(quarter.z_m, 2.0, kExact);
  EXPECT_NEAR(quarter.heading_rad, 0.5 * M_PI, kExact);
}

TEST(Motion, RoundsCornersWithoutJumps) {
  const Path path = rounded_path({{0, 0}, {0, 4}, {4, 4}}, 1.0);
  const double length = 3.0 + 0.5 * M_PI + 3.0;
  EXPECT_NEAR(pose_at(path, length).x_m, 4.0, kExact);
  for (double s = 0.0; s < length - 0.01; s += 0.01) {
    const PlanPose a = pose_at(path, s);
    const PlanPose b = pose_at(path, s + 0.01);
    EXPECT_NEAR(std::hypot(b.x_m - a.x_m, b.z_m - a.z_m), 0.01, 1e-5);
  }
}

TEST(Motion, ComesNoFurtherThanItsPath) {
  const Motion walk{.path = rounded_path({{0, 0}, {0, 4}}, 0.0), .profile = {.speed_mps = 1.0}};
  EXPECT_NEAR(way_m(walk, 3.0), 3.0, kExact);
  EXPECT_NEAR(way_m(walk, 5.0), 4.0, kExact);
  const Motion spin{
      .path = endless_path({}, 0.0), .profile = {.speed_mps = 1.0}, .spin_radps = 0.5};
  EXPECT_EQ(way_m(spin, 3.0), 0.0);
  EXPECT_NEAR(pose_at(spin, 3.0).heading_rad, 1.5, kExact);
}

}  // namespace
}  // namespace egomod::sim
