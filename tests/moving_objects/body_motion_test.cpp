// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/body_motion.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

namespace egomod {
namespace {

constexpr double kExact = 1e-9;

struct Body {
  Eigen::Vector3d velocity_mps{0.3, -0.1, 0.2};
  Eigen::Vector3d angular_radps{0.0, 0.0, 0.0};
  Eigen::Vector3d at_m{0.5, 0.2, 4.0};
};

std::vector<PointSample> points_on(const Body& body, int count, double sigma_mps,
                                   std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> noise;
  std::vector<PointSample> points(static_cast<std::size_t>(count));
  for (PointSample& point : points) {
    const Eigen::Vector3d arm_m{place(random), place(random), place(random)};
    const Eigen::Vector3d error{noise(random), noise(random), noise(random)};
    point.position_m = body.at_m + arm_m;
    point.velocity_mps = body.velocity_mps + body.angular_radps.cross(arm_m) + sigma_mps * error;
    point.velocity_covariance_m2ps2 = 1e-4 * Eigen::Matrix3d::Identity();
  }
  return points;
}

BodyMotion fit(const std::vector<PointSample>& points, const Body& body) {
  std::vector<Grouper::Index> members(points.size());
  std::iota(members.begin(), members.end(), Grouper::Index{0});
  return fit_body_motion(points, members, body.at_m, 0.2);
}

TEST(BodyMotion, IsExactForABodyThatDoesNotTurn) {
  const Body body;
  const BodyMotion motion = fit(points_on(body, 12, 0.0), body);
  EXPECT_LT((motion.velocity_mps - body.velocity_mps).norm(), kExact);
  EXPECT_EQ(motion.angular_velocity_radps.norm(), 0.0);
}

TEST(BodyMotion, SeesABodyTurnAndKeepsItsVelocityWhereItWasAsked) {
  Body body;
  body.angular_radps = {0.1, 0.7, -0.2};
  const BodyMotion motion = fit(points_on(body, 40, 0.0), body);
  // The prior on turning pulls by less than this.
  EXPECT_LT((motion.angular_velocity_radps - body.angular_radps).norm(), 2e-3);
  EXPECT_LT((motion.velocity_mps - body.velocity_mps).norm(), 1e-3);
}

TEST(BodyMotion, IsBehindByTheVarianceOfItsPointsOverTheirAgility) {
  const Body body;
  std::vector<PointSample> points = points_on(body, 12, 0.0);
  EXPECT_TRUE(fit(points, body).lag_s.isApprox(kUsualLag_s * Eigen::Matrix3d::Identity()));
  for (PointSample& point : points) {
    point.velocity_covariance_m2ps2.diagonal() = Eigen::Vector3d(4e-4, 4e-4, 4e-3);
    point.agility_m2ps3 = 5e-3;
  }
  // One centimetre a second on top, by which points of one body may differ.
  const Eigen::Vector3d lag_s{0.1, 0.1, 0.82};
  EXPECT_TRUE(fit(points, body).lag_s.isApprox(Eigen::Matrix3d(lag_s.asDiagonal()), 1e-6));
}

TEST(BodyMotion, OnePointThatMisfitsDoesNotSpeakForItsLag) {
  const Body body;
  std::vector<PointSample> points = points_on(body, 12, 0.0);
  for (PointSample& point : points) point.agility_m2ps3 = 5e-3;
  const double lag_s = fit(points, body).lag_s(2, 2);
  points.front().agility_m2ps3 *= 36.0;
  EXPECT_GT(fit(points, body).lag_s(2, 2), 0.9 * lag_s);
}

TEST(BodyMotion, TakesNoiseForNoTurn) {
  const Body body;
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    const BodyMotion motion = fit(points_on(body, 20, 2e-3, seed), body);
    EXPECT_EQ(motion.angular_velocity_radps.norm(), 0.0) << "seed " << seed;
  }
}

TEST(BodyMotion, IsTheMeanWhereThePointsAreTooFewToShowATurn) {
  Body body;
  body.angular_radps = {0.0, 0.7, 0.0};
  const BodyMotion motion = fit(points_on(body, 5, 0.0), body);
  EXPECT_EQ(motion.angular_velocity_radps.norm(), 0.0);
}

TEST(BodyMotion, IsSurerWithMorePointsButNotBeyondTheirCommonError) {
  const Body body;
  const auto variance = [&](int count) {
    return fit(points_on(body, count, 0.0), body).velocity_covariance_m2ps2.trace();
  };
  EXPECT_LT(variance(20), variance(5));
  EXPECT_NEAR(variance(2000) / variance(1000), 1.0, 0.01);
}

}  // namespace
}  // namespace egomod
