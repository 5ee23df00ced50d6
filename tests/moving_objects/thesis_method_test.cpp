// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "egomod/moving_objects/moving_object_detector.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::World;

constexpr double kExact = 1e-3;  // single precision of stored observations

MovingObjectsConfig thesis() { return {.method = MovingObjectsMethod::kThesis}; }

class Thesis : public ::testing::Test {
 protected:
  Thesis() { world.rate_hz = 5.0; }
  const MovingObjects& run(int pair) {
    const TrackSet tracks = world.tracks(pair);
    detector.detect(tracks, world.motion(tracks, pair), objects);
    return objects;
  }
  World world;
  MovingObjectDetector detector{thesis()};
  MovingObjects objects;
};

TEST_F(Thesis, StaticWorldHasNoObject) {
  world.add_background(300);
  for (int pair = 0; pair < 5; ++pair) EXPECT_TRUE(run(pair).objects.empty());
  EXPECT_TRUE(objects.has_run);
}

TEST_F(Thesis, ObjectIsMovingAtOnceWithItsVelocityAndMeanPosition) {
  world.add_box(30, {0.2, 0.1, 4.0}, {0.3, 0.3, 0.3}, {0.5, 0.0, 0.2});
  run(0);
  ASSERT_EQ(run(1).objects.size(), 1U);
  const MovingObject& object = objects.objects.front();
  EXPECT_EQ(object.state, ObjectState::kMoving);
  EXPECT_EQ(object.points, 30);
  EXPECT_LT((object.velocity_mps - world.velocity_in_camera(0, 1)).norm(), kExact);
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 30; ++i) mean_m += world.in_camera(i, 1) / 30.0;
  EXPECT_LT((object.position_m - mean_m).norm(), kExact);
}

TEST_F(Thesis, RectangleIsThatOfTheExtremeCoordinates) {
  for (const double x_m : {0.0, 0.1, 0.2}) {
    for (const double y_m : {0.0, 0.15, 0.3}) {
      world.points.push_back({{x_m, y_m, 4.0}, {0.5, 0, 0}});
    }
  }
  world.rig_velocity_mps.setZero();
  world.rig_yaw_rate_radps = 0.0;
  run(0);
  ASSERT_EQ(run(1).objects.size(), 1U);
  const PixelRect& r = objects.objects.front().rectangle;
  EXPECT_NEAR(r.u_min_px, 320.0 + 525.0 * 0.1 / 4.0, 1e-3);
  EXPECT_NEAR(r.u_max_px, 320.0 + 525.0 * 0.3 / 4.0, 1e-3);
  EXPECT_NEAR(r.v_min_px, 240.0, 1e-3);
  EXPECT_NEAR(r.v_max_px, 240.0 + 525.0 * 0.3 / 4.0, 1e-3);
}

TEST_F(Thesis, TwoObjectsOfOneVelocityAreKeptApartByDistance) {
  world.add_box(20, {-1.0, 0.0, 5.0}, {0.3, 0.3, 0.3}, {0.5, 0.0, 0.0});
  world.add_box(20, {1.0, 0.0, 5.0}, {0.3, 0.3, 0.3}, {0.5, 0.0, 0.0});
  run(0);
  EXPECT_EQ(run(1).objects.size(), 2U);
}

TEST_F(Thesis, ObjectsThatOverlapAreSplitByVelocity) {
  world.add_box(20, {0.0, 0.0, 5.0}, {0.3, 0.3, 0.3}, {0.8, 0.0, 0.0});
  world.add_box(20, {0.0, 0.0, 5.0}, {0.3, 0.3, 0.3}, {-0.8, 0.0, 0.0});
  run(0);
  EXPECT_EQ(run(1).objects.size(), 2U);
}

TEST_F(Thesis, FewerPointsThanTheMinimumAreNoObject) {
  world.add_box(thesis().group_min_points - 1, {0.0, 0.0, 4.0}, {0.2, 0.2, 0.2}, {0.6, 0, 0});
  run(0);
  EXPECT_TRUE(run(1).objects.empty());
}

TEST_F(Thesis, InliersAreNoCandidatesHoweverFast) {
  world.add_box(20, {0.0, 0.0, 4.0}, {0.3, 0.3, 0.3}, {0.6, 0, 0});
  run(0);
  const TrackSet tracks = world.tracks(1);
  Egomotion motion = world.motion(tracks, 1);
  for (TrackRole& role : motion.roles) role = TrackRole::kInlier;
  detector.detect(tracks, motion, objects);
  EXPECT_TRUE(objects.objects.empty());
}

TEST_F(Thesis, SlowerThanTheThresholdIsStatic) {
  world.add_box(20, {0.0, 0.0, 4.0}, {0.3, 0.3, 0.3}, {0.23, 0, 0});
  world.add_box(20, {1.0, 0.0, 4.0}, {0.3, 0.3, 0.3}, {0.25, 0, 0});
  run(0);
  ASSERT_EQ(run(1).objects.size(), 1U);
  EXPECT_NEAR(objects.objects.front().speed_mps, 0.25, kExact);
}

TEST_F(Thesis, IdentityIsTakenOverFromTheOverlappingGroupAndNeverReused) {
  world.add_box(20, {0.0, 0.0, 4.0}, {0.4, 0.4, 0.3}, {0.4, 0.0, 0.0});
  run(0);
  std::set<std::int64_t> ids;
  for (int pair = 1; pair < 6; ++pair) {
    ASSERT_EQ(run(pair).objects.size(), 1U);
    ids.insert(objects.objects.front().id);
  }
  EXPECT_EQ(ids.size(), 1U);
  EXPECT_NEAR(objects.objects.front().age_s, 0.8, 1e-6);

  // Unseen for a pair: the thesis knows no memory, so it comes back as somebody new.
  TrackSet tracks = world.tracks(6);
  Egomotion motion = world.motion(tracks, 6);
  motion.status = EstimateStatus::kFailed;
  detector.detect(tracks, motion, objects);
  EXPECT_TRUE(objects.objects.empty());
  ASSERT_EQ(run(7).objects.size(), 1U);
  EXPECT_FALSE(ids.contains(objects.objects.front().id));
}

TEST_F(Thesis, WorksAtItsOwnOneHertz) {
  world.rate_hz = 1.0;
  world.add_background(200);
  world.add_box(25, {-0.8, 0.0, 4.0}, {0.4, 0.4, 0.4}, {0.4, 0.0, 0.0});
  run(0);
  for (int pair = 1; pair < 4; ++pair) {
    ASSERT_EQ(run(pair).objects.size(), 1U);
    EXPECT_NEAR(objects.objects.front().speed_mps, 0.4, kExact);
  }
}

TEST_F(Thesis, ThresholdZeroTakesTheCrossingOfTheFittedLaws) {
  MovingObjectsConfig config = thesis();
  config.threshold_mps = 0.0;
  config.decision_probability = 0.99;
  MovingObjectDetector strict(config);
  world.add_box(20, {0.0, 0.0, 4.0}, {0.3, 0.3, 0.3}, {0.42, 0, 0});
  world.add_box(20, {1.0, 0.0, 4.0}, {0.3, 0.3, 0.3}, {0.45, 0, 0});
  (void)world.tracks(0);
  const TrackSet tracks = world.tracks(1);
  strict.detect(tracks, world.motion(tracks, 1), objects);
  ASSERT_EQ(objects.objects.size(), 1U) << "the 99 % threshold lies at 0.434 m/s";
  EXPECT_GT(objects.objects.front().motion_probability, 0.99);
}

TEST_F(Thesis, SkippedPairHasNotRun) {
  world.add_background(50);
  run(0);
  TrackSet tracks = world.tracks(1);
  tracks.pair_status = PairStatus::kSkipped;
  tracks.status = TrackStatus::kNotRun;
  Egomotion motion = world.motion(tracks, 1);
  motion.status = EstimateStatus::kSkipped;
  detector.detect(tracks, motion, objects);
  EXPECT_FALSE(objects.has_run);
}

}  // namespace
}  // namespace egomod
