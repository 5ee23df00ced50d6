// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "egomod/moving_objects/moving_object_detector.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::World;

class Lag : public ::testing::Test {
 protected:
  const MovingObjects& run(int pair, EstimateStatus status = EstimateStatus::kValid) {
    const TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    if (pair > 0) motion.status = status;
    detector.detect(tracks, motion, objects);
    return objects;
  }
  void realistic_noise() {
    world.pixel_sigma = 0.18;
    world.disparity_sigma_px = 0.25;
  }
  [[nodiscard]] int moving() const {
    int count = 0;
    for (const MovingObject& object : objects.objects) {
      count += object.state == ObjectState::kMoving;
    }
    return count;
  }
  World world;
  MovingObjectDetector detector{MovingObjectsConfig{.method = MovingObjectsMethod::kLag}};
  MovingObjects objects;
};

class LagRate : public Lag, public ::testing::WithParamInterface<double> {};

TEST_P(LagRate, FindsWalkingPaceAtFiveMetresWithinSixTenths) {
  world.rate_hz = GetParam();
  realistic_noise();
  world.add_background(400);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.4, 0.0, 0.0});
  int pair = 0;
  for (; world.time_s(pair) <= 0.6 && moving() == 0; ++pair) run(pair);
  ASSERT_EQ(moving(), 1) << "not found by " << world.time_s(pair) << " s";
  const MovingObject& object = objects.objects.front();
  const Eigen::Vector3d truth_mps = world.velocity_in_camera(400, pair - 1);
  EXPECT_LT((object.velocity_mps - truth_mps).norm(), 0.1);
  EXPECT_NEAR(object.position_m.z(), world.in_camera(400, pair - 1).z(), 0.4);
  EXPECT_GT(object.motion_probability, 0.99);
  EXPECT_GT(object.speed_sigma_mps, 0.0);
  EXPECT_LT(object.speed_sigma_mps, 0.2);
}

TEST_P(LagRate, NoiseIsNoObject) {
  world.rate_hz = GetParam();
  realistic_noise();
  world.rig_velocity_mps = {0.0, 0.0, 0.1};
  world.rig_yaw_rate_radps = 0.02;
  world.add_background(700, 4.0, 15.0);
  for (int pair = 0; pair < 300; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, LagRate, ::testing::Values(30.0, 10.0));

TEST_F(Lag, StaticWorldHasNoObjectFromAMovingRig) {
  world.rig_velocity_mps = {0.2, 0.0, 1.0};
  world.rig_yaw_rate_radps = 0.4;
  world.add_background(500);
  for (int pair = 0; pair < 60; ++pair) EXPECT_TRUE(run(pair).objects.empty());
}

TEST_F(Lag, WorksAtOneHertz) {
  world.rate_hz = 1.0;
  realistic_noise();
  world.add_background(300);
  world.add_box(30, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.3, 0.0, 0.0});
  for (int pair = 0; pair < 4; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

TEST_F(Lag, IdentityStaysWithItsTracksAndIsNobodyElses) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300);
  world.add_box(40, {-1.0, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  world.add_box(40, {1.0, 0.1, 6.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  std::set<std::int64_t> ids;
  for (int pair = 0; pair < 20; ++pair) {
    for (const MovingObject& object : run(pair).objects) {
      if (object.state == ObjectState::kMoving) ids.insert(object.id);
    }
  }
  EXPECT_EQ(moving(), 2);
  EXPECT_EQ(ids.size(), 2U);

  // Out of sight for longer than an object coasts; who comes then, 3 m further away, is another.
  std::vector<synthetic::Point> points = world.points;
  for (std::size_t i = 300; i < points.size(); ++i) points[i].at_start_m.z() += 3.0;
  for (std::size_t i = 300; i < world.points.size(); ++i) world.points[i].at_start_m.z() = -50.0;
  for (int pair = 20; pair < 45; ++pair) run(pair);
  EXPECT_TRUE(objects.objects.empty());
  world.points = points;
  for (int pair = 45; pair < 55; ++pair) run(pair);
  ASSERT_GT(moving(), 0);
  for (const MovingObject& object : objects.objects) EXPECT_FALSE(ids.contains(object.id));
}

TEST_F(Lag, ObjectsThatOverlapAreSplitByVelocity) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.add_background(300);
  world.add_box(30, {0.0, 0.1, 5.0}, {0.4, 0.5, 0.4}, {0.8, 0.0, 0.0});
  world.add_box(30, {0.0, 0.1, 5.0}, {0.4, 0.5, 0.4}, {-0.8, 0.0, 0.0});
  for (int pair = 0; pair < 8; ++pair) run(pair);
  EXPECT_EQ(moving(), 2);
}

TEST_F(Lag, PointsThatSlideAlongTheirOwnLineAreNoObject) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.rig_velocity_mps.setZero();
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300);
  world.add_box(20, {0.0, 0.5, 5.0}, {1.5, 0.0, 0.0}, {0.6, 0.0, 0.0});  // a kerb
  for (int pair = 0; pair < 15; ++pair) EXPECT_TRUE(run(pair).objects.empty());
}

TEST_F(Lag, BarThatMovesAcrossItselfIsAnObject) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.rig_velocity_mps.setZero();
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300);
  world.add_box(20, {0.0, 0.5, 5.0}, {1.5, 0.0, 0.0}, {0.0, -0.6, 0.0});
  for (int pair = 0; pair < 10; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

TEST_F(Lag, StoppedObjectIsNotMoving) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.rig_velocity_mps.setZero();
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  int pair = 0;
  for (; pair < 12; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  for (std::size_t i = 300; i < world.points.size(); ++i) {
    world.points[i].at_start_m += world.time_s(pair) * world.points[i].velocity_mps;
    world.points[i].velocity_mps.setZero();
  }
  for (const int end = pair + 6; pair < end; ++pair) run(pair);
  ASSERT_EQ(objects.objects.size(), 1U);
  EXPECT_EQ(objects.objects.front().state, ObjectState::kStopped);
  for (const int end = pair + 25; pair < end; ++pair) run(pair);
  EXPECT_TRUE(objects.objects.empty());
}

TEST_F(Lag, AmbiguousMotionConfirmsNothing) {
  world.rate_hz = 10.0;
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 12; ++pair) {
    run(pair, EstimateStatus::kAmbiguous);
    EXPECT_EQ(moving(), 0);
  }
  EXPECT_FALSE(objects.objects.empty());
}

TEST_F(Lag, FailedMotionHasRunAndFindsNothing) {
  world.rate_hz = 10.0;
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 12; ++pair) run(pair, EstimateStatus::kFailed);
  EXPECT_TRUE(objects.has_run);
  EXPECT_TRUE(objects.objects.empty());
}

TEST_F(Lag, ResetForgetsThePast) {
  world.rate_hz = 10.0;
  world.add_background(300);
  for (int pair = 0; pair < 8; ++pair) run(pair);
  // After the reset the pose starts elsewhere: compared with the past everything would fly.
  for (int pair = 8; pair < 20; ++pair) {
    const TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    motion.reset_count = 1;
    motion.T_first_current.translation().x() += 3.0;
    detector.detect(tracks, motion, objects);
    EXPECT_TRUE(objects.objects.empty());
  }
}

TEST_F(Lag, NothingThatIsNotFiniteLeaves) {
  world.rate_hz = 10.0;
  realistic_noise();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int pair = 0; pair < 20; ++pair) {
    TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    for (std::size_t i = 0; i < tracks.tracks.size(); i += 7) {
      tracks.tracks[i].current.disparity_px = static_cast<float>(nan);
    }
    if (pair == 10) motion.T_first_current.translation().x() = nan;
    if (pair == 13) motion.T_previous_current.linear()(0, 0) = nan;
    if (pair == 16) motion.covariance_previous_current(0, 0) = nan;
    if (pair == 18) motion.roles.clear();
    detector.detect(tracks, motion, objects);
    for (const MovingObject& object : objects.objects) {
      EXPECT_TRUE(object.position_m.allFinite() && object.velocity_mps.allFinite());
      EXPECT_TRUE(std::isfinite(object.speed_mps) && std::isfinite(object.motion_probability));
    }
    for (const PointMotion& point : objects.points) EXPECT_TRUE(point.velocity_mps.allFinite());
  }
}

}  // namespace
}  // namespace egomod
