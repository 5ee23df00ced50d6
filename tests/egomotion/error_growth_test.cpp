// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/error_growth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace egomod {
namespace {

constexpr double kPair_s = 1.0 / 30.0;

// A right camera whose yaw is known to 1 mrad; the median point has a disparity of 21 px.
struct DoubtedYaw {
  TrackSet tracks;
  std::vector<Correspondence> seen;
  std::vector<double> scratch;
  ScaleDoubt doubt;

  DoubtedYaw() {
    tracks.camera = {525.0, 525.0, 320.0, 240.0, 0.375, 640, 480};
    tracks.right_turn.is_off = true;
    tracks.right_turn.yaw_sigma_rad = 1e-3;
    seen.resize(9);
    for (Correspondence& point : seen) point.observed_px = {320.0, 240.0, 21.0};
  }
  Matrix6d note(const Eigen::Vector3d& way_m) {
    Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
    T_previous_current.translation() = way_m;
    return doubt.note(tracks, seen, T_previous_current, kPair_s, scratch);
  }
};

TEST(ScaleDoubt, IsTheShareOfTheDisparityThatTheYawMayBeOffBy) {
  DoubtedYaw yaw;
  yaw.note({0.0, 0.0, 0.02});
  EXPECT_NEAR(yaw.doubt.sigma(), 0.525 / 21.0, 1e-12);
  const Matrix6d& covariance = yaw.doubt.covariance();
  EXPECT_NEAR(std::sqrt(covariance(2, 2)), 0.02 * 0.025, 1e-12);
}

TEST(ScaleDoubt, AddsUpAlongTheWayOfASecond) {
  DoubtedYaw yaw;
  Matrix6d grown = Matrix6d::Zero();
  for (int pair = 0; pair < 120; ++pair) {
    const Matrix6d growth = yaw.note({0.0, 0.0, 0.01});
    if (pair >= 90) grown += growth;
  }
  // 0.3 m: a random walk would be off by a fifth of the share of it.
  EXPECT_NEAR(std::sqrt(grown(2, 2)), 0.025 * 0.3, 0.1 * 0.025 * 0.3);
}

TEST(ScaleDoubt, BendsAndTurnsTheWayLessThanItStretchesIt) {
  DoubtedYaw yaw;
  yaw.note({0.0, 0.0, 0.02});
  const Matrix6d& covariance = yaw.doubt.covariance();
  EXPECT_GT(covariance(0, 0), 0.0);
  EXPECT_LT(covariance(0, 0), 0.01 * covariance(2, 2));
  EXPECT_EQ(covariance(0, 0), covariance(1, 1));
  EXPECT_GT(covariance(3, 3), 0.0);
  EXPECT_EQ(covariance(5, 5), 0.0) << "about the way itself";
}

TEST(ScaleDoubt, IsAlongTheWayAsTheNewPoseSeesIt) {
  DoubtedYaw yaw;
  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  T_previous_current.linear() =
      Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T_previous_current.translation() =
      Eigen::Vector3d(0.0, 0.0, 0.02);  // to the left of where it looks now
  const Matrix6d growth =
      yaw.doubt.note(yaw.tracks, yaw.seen, T_previous_current, kPair_s, yaw.scratch);
  for (const Matrix6d& covariance : {growth, yaw.doubt.covariance()}) {
    EXPECT_GT(covariance(0, 0), 0.0);
    EXPECT_LT(covariance(2, 2), 0.01 * covariance(0, 0));
  }
}

TEST(ScaleDoubt, IsNoneAtRestAndWhereTheCameraHasNotTurned) {
  DoubtedYaw yaw;
  EXPECT_TRUE(yaw.note(Eigen::Vector3d::Zero()).isZero());
  yaw.tracks.right_turn.is_off = false;
  EXPECT_TRUE(yaw.note({0.0, 0.0, 0.02}).isZero());
  EXPECT_EQ(yaw.doubt.sigma(), 0.0);
  EXPECT_TRUE(yaw.doubt.covariance().isZero());
}

}  // namespace
}  // namespace egomod
