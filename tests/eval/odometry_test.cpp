// SPDX-License-Identifier: Apache-2.0
#include "odometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace egomod::eval {
namespace {

constexpr double kExact = 1e-9;

// One metre a frame along z, `scale` times as far.
Poses straight(int frames, double scale) {
  Poses poses;
  for (int i = 0; i < frames; ++i) {
    poses.push_back({i, Eigen::Isometry3d::Identity()});
    poses.back().T_world_camera.translation().z() = scale * i;
  }
  return poses;
}

TEST(Odometry, OfTheTruthItselfHasNoError) {
  const OdometryFigures figures = score_odometry(straight(11, 1.0), straight(11, 1.0));
  EXPECT_NEAR(figures.pair_mm->max, 0.0, kExact);
  EXPECT_NEAR(figures.rigid_aligned_rmse_m, 0.0, kExact);
  EXPECT_NEAR(figures.drift->translation_percent, 0.0, kExact);
  EXPECT_NEAR(figures.path_m, 10.0, kExact);
}

// 2 % too far: every stretch drifts by 2 %, each pair by 20 mm, position i by 20 i mm; the rms of
// 0..10 is sqrt(385 / 11), that about their mean 5 is sqrt(10).
TEST(Odometry, OfTwoPercentTooMuchIsWorkedOutByHand) {
  const OdometryFigures figures = score_odometry(straight(11, 1.0), straight(11, 1.02));
  EXPECT_NEAR(figures.drift->translation_percent, 2.0, kExact);
  EXPECT_EQ(figures.drift->per_length.size(), 7U);
  EXPECT_NEAR(figures.pair_mm->median, 20.0, 1e-6);
  EXPECT_NEAR(figures.first_aligned_rmse_m, 0.02 * std::sqrt(35.0), kExact);
  EXPECT_NEAR(figures.rigid_aligned_rmse_m, 0.02 * std::sqrt(10.0), kExact);
  EXPECT_NEAR(figures.end_error_m, 0.2, kExact);
}

TEST(Odometry, DoesNotDependOnTheEstimatesWorld) {
  Poses moved = straight(11, 1.02);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(4, 5, 6);
  for (NumberedPose& pose : moved) pose.T_world_camera = T * pose.T_world_camera;
  const OdometryFigures figures = score_odometry(straight(11, 1.0), moved);
  EXPECT_NEAR(figures.drift->translation_percent, 2.0, 1e-6);
  EXPECT_NEAR(figures.first_aligned_rmse_m, 0.02 * std::sqrt(35.0), 1e-6);
}

TEST(Odometry, CountsPairsOnlyWhereBothFramesAreThere) {
  Poses gap = straight(11, 1.02);
  gap.erase(gap.begin() + 5);
  const OdometryFigures figures = score_odometry(straight(11, 1.0), gap);
  EXPECT_EQ(figures.frames, 10);
  EXPECT_EQ(figures.pair_mm->count, 8U);
}

TEST(Odometry, LeavesPosesThatAreNotFiniteOutAndSaysSo) {
  Poses broken = straight(11, 1.0);
  broken[4].T_world_camera.translation().x() = std::nan("");
  const OdometryFigures figures = score_odometry(straight(11, 1.0), broken);
  EXPECT_FALSE(figures.finite);
  EXPECT_NEAR(figures.end_error_m, 0.0, kExact);
}

TEST(Odometry, GivesNoDriftForAPathTooShort) {
  EXPECT_FALSE(score_odometry(straight(11, 0.01), straight(11, 0.011)).drift.has_value());
}

TEST(Odometry, MeasuresSmallAngles) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(1e-9, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(angle_deg(T), 1e-9 * 180.0 / std::numbers::pi, 1e-16);
}

}  // namespace
}  // namespace egomod::eval
