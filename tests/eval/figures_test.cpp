// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "consistency.hpp"
#include "figure_tables.hpp"
#include "points.hpp"
#include "statistics.hpp"

namespace egomod::eval {
namespace {

constexpr double kExact = 1e-9;

TEST(Statistics, AreThoseOfAHandfulOfNumbers) {
  const auto s = summarise({4.0, 1.0, std::nan(""), 3.0, 2.0});
  EXPECT_EQ(s->count, 4U);
  EXPECT_NEAR(s->median, 2.5, kExact);
  EXPECT_NEAR(s->mean, 2.5, kExact);
  EXPECT_NEAR(s->p90, 3.7, kExact);
  EXPECT_NEAR(s->rmse, std::sqrt(7.5), kExact);
  EXPECT_FALSE(summarise({std::nan("")}).has_value());
}

Truth standing(int frames) {
  Truth truth;
  for (int i = 0; i < frames; ++i) {
    truth.times_s.push_back(0.5 * i);
    truth.poses.push_back({i, Eigen::Isometry3d::Identity()});
  }
  return truth;
}

// Each pose is 2 sigma off along one axis: NEES 4 of 6 degrees of freedom.
TEST(Consistency, OfAPoseTwoSigmaOffIsFourOverSix) {
  std::vector<PoseEvidence> poses(5);
  for (int i = 0; i < 5; ++i) {
    PoseEvidence& pose = poses[static_cast<std::size_t>(i)];
    pose.frame = i;
    pose.estimated = true;
    pose.covariance = 1e-4 * i * Eigen::Matrix<double, 6, 6>::Identity();
    pose.T_first_camera.translation().x() = 2.0 * std::sqrt(1e-4 * i);
  }
  const ConsistencyFigures figures = score_consistency(standing(5), poses, {});
  EXPECT_EQ(figures.pose->count, 4U);
  EXPECT_NEAR(figures.pose->mean_per_dof, 4.0 / 6.0, 1e-6);
  EXPECT_NEAR(figures.pose->within_95, 1.0, kExact);
  EXPECT_EQ(figures.second_by_pose->count, 3U);  // from 0, 1 and 2, two pairs each
  EXPECT_FALSE(figures.pair.has_value());
}

TEST(Consistency, OfMotionsComposesThePairs) {
  std::vector<PoseEvidence> poses(3);
  for (int i = 0; i < 3; ++i) {
    PoseEvidence& pose = poses[static_cast<std::size_t>(i)];
    pose.frame = i;
    pose.estimated = true;
    pose.motion_covariance = 0.5 * Eigen::Matrix<double, 6, 6>::Identity();
    pose.T_first_camera.translation().y() = 0.5 * i;
  }
  const ConsistencyFigures figures = score_consistency(standing(3), poses, {});
  EXPECT_NEAR(figures.pair->mean_per_dof, 0.25 / 0.5 / 6.0, 1e-9);
  EXPECT_NEAR(figures.second_by_pairs->mean_per_dof, 1.0 / 1.0 / 6.0, 1e-9);
}

Truth scene_of_points() {
  Truth truth;
  truth.times_s = {0.0, 1.0};
  TruthObject mover;
  mover.surface_m = {0.0, 0.0, 5.0};
  mover.centre_m = {0.0, 0.0, 5.2};
  mover.rectangle = {100, 100, 200, 200};
  mover.visible_px = 5000;
  mover.moving = true;
  truth.objects.emplace();
  (*truth.objects)[1].push_back(mover);
  return truth;
}

PointEvidence point(double u_px, double depth_m, double speed_mps, bool moving) {
  return {.frame = 1,
          .u_px = u_px,
          .v_px = 150.0,
          .depth_m = depth_m,
          .speed_mps = speed_mps,
          .moving = moving};
}

// Speeds 1.0 and 0.3 move, 0.4 and 0.1 do not: three of the four pairs are in the right order.
TEST(Points, AreCountedByRectangleAndDepth) {
  const PointFigures figures = score_points(
      scene_of_points(),
      {point(150, 5.1, 1.0, true), point(150, 5.0, 0.3, false), point(150, 9.0, 2.0, true),
       point(50, 5.0, 0.4, true), point(300, 2, 0.1, false)},
      1);
  EXPECT_EQ(figures.moving, 2);
  EXPECT_EQ(figures.still, 2);
  EXPECT_EQ(figures.left_out, 1);
  EXPECT_EQ(figures.tp, 1);
  EXPECT_EQ(figures.fp, 1);
  EXPECT_EQ(figures.fn, 1);
  EXPECT_NEAR(*figures.f1, 0.5, kExact);
  EXPECT_NEAR(*figures.area, 0.75, kExact);
}

TEST(Tables, AlignTheirColumns) {
  EXPECT_EQ(text_of({"T", {"", "n"}, {{"a", "1"}, {"bcd", "22"}}}),
            "T\n        n\n  a     1\n  bcd  22\n");
}

}  // namespace
}  // namespace egomod::eval
