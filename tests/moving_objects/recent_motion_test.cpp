// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/recent_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace egomod {
namespace {

const Eigen::Vector3d kAt_m{0.3, 0.1, 5.0};
const Eigen::Vector3d kNow_mps{0.0, 0.0, 0.4};

struct Points {
  std::vector<RecentVelocities> recent;
  std::vector<PointSample> samples;
};

// Points whose windows say `velocity_of(window)`, with the noise that they say.
template <typename Field>
Points points_of(int count, const Field& velocity_of, double sigma_m = 0.01) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  Points points;
  points.recent.resize(static_cast<std::size_t>(count));
  points.samples.resize(points.recent.size());
  for (std::size_t i = 0; i < points.samples.size(); ++i) {
    PointSample& point = points.samples[i];
    RecentVelocities& recent = points.recent[i];
    point.recent = &recent;
    point.position_m = kAt_m + 0.3 * Eigen::Vector3d(noise(random), noise(random), 0.0);
    recent.position_covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    for (std::size_t k = 0; k < kRecentPairs.size(); ++k) {
      const auto n = static_cast<double>(kRecentPairs[k]);
      const double gain_hz2 = 900.0 * 12.0 / (n * (n * n - 1.0));
      const double sigma_mps = std::sqrt(gain_hz2) * sigma_m;
      const Eigen::Vector3d error{noise(random), noise(random), noise(random)};
      recent.windows[k] = {velocity_of(k, point.position_m) + sigma_mps * error, gain_hz2,
                           (n - 1.0) / 30.0};
    }
    recent.count = kRecentPairs.size();
  }
  return points;
}

RecentMotion fit(const Points& points, const Eigen::Vector3d& velocity_mps,
                 const BodyMotion& body = {}) {
  std::vector<Grouper::Index> members(points.samples.size());
  std::iota(members.begin(), members.end(), Grouper::Index{0});
  return fit_recent_motion(points.samples, members, body, kAt_m, velocity_mps,
                           Eigen::Matrix3d::Zero());
}

TEST(RecentMotion, LeavesAVelocityThatIsRight) {
  const auto points = points_of(40, [](auto, const auto&) { return kNow_mps; });
  const RecentMotion recent = fit(points, kNow_mps);
  EXPECT_EQ(recent.proven, 0.0);
  Eigen::Vector3d velocity_mps = kNow_mps;
  Eigen::Matrix3d manoeuvres = 0.01 * Eigen::Matrix3d::Identity();
  take(recent, Eigen::Matrix3d::Zero(), velocity_mps, manoeuvres);
  EXPECT_EQ(velocity_mps, kNow_mps);
  // That it makes no manoeuvre is known by now.
  EXPECT_LT(manoeuvres.trace(), 0.1 * 0.03);
}

TEST(RecentMotion, CatchesUpWithABodyThatHasStarted) {
  // It started three pairs ago: longer windows begin before.
  const auto points = points_of(
      40,
      [](std::size_t k, const auto&) -> Eigen::Vector3d {
        return kNow_mps * 3.0 / static_cast<double>(kRecentPairs[k]);
      },
      0.004);
  Eigen::Vector3d velocity_mps = 0.25 * kNow_mps;
  Eigen::Matrix3d manoeuvres = Eigen::Matrix3d::Zero();
  const RecentMotion recent = fit(points, velocity_mps);
  EXPECT_GT(recent.proven, 0.3);
  take(recent, Eigen::Matrix3d::Zero(), velocity_mps, manoeuvres);
  EXPECT_LT((velocity_mps - kNow_mps).norm(), 0.12);
}

TEST(RecentMotion, BelievesAnExpectedChangeSooner) {
  const auto points = points_of(
      8, [](auto, const auto&) { return kNow_mps; }, 0.05);
  const auto taken = [&](double start_mps) {
    Eigen::Vector3d velocity_mps = 0.7 * kNow_mps;
    Eigen::Matrix3d manoeuvres = Eigen::Matrix3d::Zero();
    take(fit(points, velocity_mps), start_mps * start_mps * Eigen::Matrix3d::Identity(),
         velocity_mps, manoeuvres);
    return (velocity_mps - 0.7 * kNow_mps).norm();
  };
  EXPECT_EQ(taken(0.0), 0.0);
  EXPECT_GT(taken(0.3), 0.03);
}

TEST(RecentMotion, TakesARotationForNoChange) {
  BodyMotion body;
  body.angular_velocity_radps = {0.0, 1.0, 0.0};
  const auto points = points_of(40, [&](auto, const Eigen::Vector3d& at_m) -> Eigen::Vector3d {
    return kNow_mps + body.angular_velocity_radps.cross(at_m - kAt_m);
  });
  EXPECT_EQ(fit(points, kNow_mps, body).proven, 0.0);
}

TEST(RecentMotion, HearsNoFewPoints) {
  const auto points = points_of(4, [](auto, const auto&) { return kNow_mps; });
  const RecentMotion recent = fit(points, Eigen::Vector3d::Zero());
  EXPECT_EQ(recent.proven, 0.0);
  Eigen::Vector3d velocity_mps{0.1, 0.0, 0.0};
  Eigen::Matrix3d manoeuvres = Eigen::Matrix3d::Identity();
  take(recent, Eigen::Matrix3d::Zero(), velocity_mps, manoeuvres);
  EXPECT_EQ(manoeuvres, Eigen::Matrix3d::Identity());
  EXPECT_EQ(velocity_mps.x(), 0.1);
}

}  // namespace
}  // namespace egomod
