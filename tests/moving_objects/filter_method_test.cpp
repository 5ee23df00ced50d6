// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include "filter_fixture.hpp"

namespace egomod {
namespace {

using synthetic::World;

struct Delay {
  double depth_m;
  Eigen::Vector3d velocity_mps;
  double limit_s;
};

// Else GoogleTest prints bytes.
void PrintTo(const Delay& delay, std::ostream* out) {
  *out << delay.velocity_mps.transpose() << " m/s at " << delay.depth_m << " m";
}

class FilterDelay : public Filter, public ::testing::WithParamInterface<Delay> {};

TEST_P(FilterDelay, MoverIsFoundInTime) {
  const Delay& p = GetParam();
  world.add_background(400);
  world.add_box(40, {-0.5, 0.1, p.depth_m}, {0.6, 0.6, 0.4}, p.velocity_mps);
  EXPECT_LE(delay_s(3.0), p.limit_s);
}

INSTANTIATE_TEST_SUITE_P(
    At30Hz, FilterDelay,
    ::testing::Values(Delay{5.0, {0.4, 0.0, 0.0}, 0.11}, Delay{12.0, {0.4, 0.0, 0.0}, 0.2},
                      Delay{3.0, {0.1, 0.0, 0.0}, 0.3}, Delay{6.0, {0.05, 0.0, 0.0}, 1.0},
                      Delay{5.0, {0.0, 0.0, 0.4}, 0.3}, Delay{8.0, {0.0, 0.0, 0.4}, 0.7},
                      Delay{12.0, {0.0, 0.0, -0.4}, 1.5}, Delay{5.0, {0.0, 0.0, 0.1}, 1.5}));

class FilterRate : public Filter, public ::testing::WithParamInterface<double> {};

TEST_P(FilterRate, VelocityIsAsTrueAsItsErrorSays) {
  world.rate_hz = GetParam();
  world.add_background(400);
  world.add_box(40, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.4, 0.0, 0.2});
  int pair = 0;
  for (; world.time_s(pair) <= 2.0 || pair < 4; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const MovingObject& object = objects.objects.front();
  const Eigen::Vector3d truth_mps = world.velocity_in_camera(400, pair - 1);
  EXPECT_LT((object.velocity_mps - truth_mps).norm(), 0.05);
  EXPECT_LT((object.velocity_mps - truth_mps).norm(), 4.0 * object.speed_sigma_mps);
  EXPECT_GT(object.motion_probability, 0.99);
}

TEST_P(FilterRate, NoiseIsNoObject) {
  world.rate_hz = GetParam();
  world.rig_velocity_mps = {0.0, 0.0, 0.05};
  world.rig_yaw_rate_radps = 0.005;
  world.add_background(500, 6.0, 15.0);
  for (int pair = 0; pair < 1000; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, FilterRate, ::testing::Values(30.0, 10.0));

TEST_F(Filter, WorksAtOneHertz) {
  world.rate_hz = 1.0;
  world.add_background(300);
  world.add_box(30, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.3, 0.0, 0.0});
  for (int pair = 0; pair < 5; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

class LongIntervals : public Filter, public ::testing::WithParamInterface<double> {};

TEST_P(LongIntervals, OneTellsWhatMoves) {
  world.rate_hz = GetParam();
  world.add_background(300);
  world.add_box(30, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.3, 0.0, 0.0});
  for (int pair = 0; pair < 2; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

TEST_P(LongIntervals, OneTellsWhatStarts) {
  rest_rig();
  world.rate_hz = GetParam();
  world.add_background(300);
  world.add_box(30, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.0});
  int pair = 0;
  for (; pair < 4; ++pair) run(pair);
  ASSERT_EQ(moving(), 0);
  turn(pair - 1, 300, {0.5, 0.0, 0.0});
  run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_NEAR(objects.objects.front().velocity_mps.x(), 0.5, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Rates, LongIntervals, ::testing::Values(5.0, 1.0));

// A hole is no low rate: its pair tells no more than any other.
TEST_F(Filter, AHoleTellsNoMoreThanAnyOtherPair) {
  rest_rig();
  world.rate_hz = 30.0;
  world.add_background(300);
  world.add_box(30, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.0});
  int pair = 0;
  for (; pair < 30; ++pair) run(pair);
  turn(pair - 1, 300, {0.5, 0.0, 0.0});
  pair += 9;
  run(pair);
  EXPECT_EQ(moving(), 0);
  for (int after = 1; after < 5; ++after) run(pair + after);
  EXPECT_EQ(moving(), 1);
}

// At the left border, and behind something nearer, the right camera sees nothing of what the left
// one does; its disparities there are of anything.
class LeftOnly : public Filter, public ::testing::WithParamInterface<int> {
 protected:
  static constexpr std::size_t kFirst = 400;
  static constexpr int kPairsBefore = 60;
  void run_hidden(int pair) {
    TrackSet tracks = world.tracks(pair);
    const Egomotion motion = world.motion(tracks, pair);
    for (Track& track : tracks.tracks) {
      if (track.id <= kFirst) continue;
      track.has_current = false;
      track.left_only = true;
      track.current.disparity_px *= 1.2F;
    }
    detector.detect(tracks, motion, objects);
  }
};

TEST_P(LeftOnly, PointsCarryOnAKnownObject) {
  world.add_background(kFirst);
  world.add_box(30, {0.5, 0.1, 4.0}, {0.5, 0.5, 0.2}, {-0.4, 0.0, 0.0});
  int pair = 0;
  for (; pair < kPairsBefore; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const Eigen::Vector3d before_m = objects.objects.front().position_m;
  for (; pair < kPairsBefore + GetParam(); ++pair) {
    run_hidden(pair);
    ASSERT_EQ(moving(), 1) << "pair " << pair;
  }
  const MovingObject& object = objects.objects.front();
  EXPECT_GE(object.points, 15);
  const double nearer_m = world.rig_velocity_mps.z() * (world.time_s(GetParam()) - world.time_s(0));
  EXPECT_NEAR(object.position_m.z(), before_m.z() - nearer_m, 0.05);
  EXPECT_LT((object.velocity_mps - world.velocity_in_camera(kFirst, pair - 1)).norm(), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Pairs, LeftOnly, ::testing::Values(1, 15));

TEST_F(LeftOnly, PointsMakeNoObject) {
  world.add_background(kFirst);
  world.add_box(30, {0.5, 0.1, 4.0}, {0.5, 0.5, 0.2}, {-0.4, 0.0, 0.0});
  run(0);
  for (int pair = 1; pair < 30; ++pair) run_hidden(pair);
  EXPECT_TRUE(objects.objects.empty());
}

TEST_F(Filter, FewThatAgreeAmongManyThatRestAreNoObjectAtOneHertz) {
  rest_rig();
  world.rate_hz = 1.0;
  world.add_background(300);
  world.add_box(12, {0.0, 0.1, 5.0}, {0.6, 0.6, 0.2}, {0.0, 0.0, 0.0});
  world.add_box(15, {0.0, 0.1, 5.0}, {0.6, 0.6, 0.2}, {0.3, 0.0, 0.0});
  for (int pair = 0; pair < 2; ++pair) run(pair);
  EXPECT_TRUE(objects.objects.empty());
}

TEST_F(Filter, NoiseIsNoObjectAtOneHertz) {
  world.rate_hz = 1.0;
  world.rig_velocity_mps = {0.0, 0.0, 0.1};
  world.rig_yaw_rate_radps = 0.005;
  world.add_background(500, 6.0, 15.0);
  for (int pair = 0; pair < 60; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

TEST_F(Filter, WrongMotionOfTheRigIsNoObjectAtOnce) {
  rest_rig();
  world.rate_hz = 5.0;
  world.add_background(300);
  int pair = 0;
  for (; pair < 5; ++pair) run(pair);
  const TrackSet tracks = world.tracks(pair);
  Egomotion motion = world.motion(tracks, pair);
  motion.T_first_current.linear() = so3_exp({0.0, 0.01, 0.0});
  motion.T_previous_current = motion.T_first_current;
  detector.detect(tracks, motion, objects);
  EXPECT_EQ(moving(), 0);
}

TEST_F(Filter, SpeedOfACarNeedsNoOtherParameters) {
  world.rate_hz = 10.0;
  world.rig_velocity_mps = {0.0, 0.0, 11.0};
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300, 20.0, 35.0);
  world.add_box(40, {2.0, 0.5, 9.0}, {1.7, 1.4, 2.0}, {0.0, 0.0, 14.0});
  int pair = 0;
  for (; pair < 8; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_NEAR(objects.objects.front().velocity_mps.z(), 14.0, 0.3);
}

TEST_F(Filter, WhatStartsAfterLongRestIsFound) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.0});
  int pair = 0;
  for (; pair < 100; ++pair) run(pair);
  turn(pair, 300, {0.15, 0.0, 0.0});
  for (; pair < 121; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

// Rest has taught the filters a velocity of nothing, which a start must not have to wear down.
TEST_F(Filter, WhatStartsAfterOneSecondOfRestIsFoundAtOnce) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.0});
  int pair = 0;
  for (; pair < 30; ++pair) run(pair);
  turn(pair - 1, 300, {0.5, 0.0, 0.0});
  for (; pair < 33; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const MovingObject& object = objects.objects.front();
  const Eigen::Vector3d error_mps = object.velocity_mps - Eigen::Vector3d(0.5, 0.0, 0.0);
  EXPECT_LT(error_mps.norm(), 0.1);
  EXPECT_LT(error_mps.dot(object.velocity_covariance_m2ps2.ldlt().solve(error_mps)), 11.34);
}

// Of a box's velocity, by what the rows of a rolling shutter show of it.
double velocity_error_mps(bool told) {
  World world;
  world.rig_yaw_rate_radps = 0.4;
  world.add_background(200);
  world.add_box(20, {0.3, 1.2, 4.0}, {0.6, 0.5, 0.3}, {0.4, 0.0, 0.0});
  Vector6d velocity;
  velocity << world.rig_velocity_mps, 0.0, -world.rig_yaw_rate_radps, 0.0;
  const RowTiming rows{0.025, velocity};
  MovingObjectDetector detector{{.method = MovingObjectsMethod::kFilter}};
  MovingObjects objects;
  for (int pair = 0; pair < 20; ++pair) {
    TrackSet tracks = world.tracks(pair);
    for (Track& track : tracks.tracks) {
      const Eigen::Vector3d P = triangulate(tracks.camera, uvd(track.current));
      const Eigen::Vector3d by =
          rows.readout_s * row_displacement_per_s(tracks.camera, P, rows.velocity);
      track.current.u_px += static_cast<float>(by.x());
      track.current.v_px += static_cast<float>(by.y());
      track.current.disparity_px += static_cast<float>(by.z());
    }
    Egomotion motion = world.motion(tracks, pair);
    if (told) motion.rows = rows;
    detector.detect(tracks, motion, objects);
  }
  if (objects.objects.size() != 1) return 1000.0;
  const Eigen::Vector3d truth = world.velocity_in_camera(world.points.size() - 1, 19);
  return (objects.objects[0].velocity_mps - truth).norm();
}

TEST_F(Filter, RowsAreSeenAsOfTheMiddleOne) {
  const double told = velocity_error_mps(true);
  EXPECT_LT(told, 0.02);
  EXPECT_LT(2 * told, velocity_error_mps(false));
}

TEST_F(Filter, AmbiguousMotionConfirmsNothing) {
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 20; ++pair) {
    run(pair, EstimateStatus::kAmbiguous);
    EXPECT_EQ(moving(), 0);
  }
  EXPECT_GT(count(ObjectState::kTentative), 0);
}

TEST_F(Filter, FailedPairsInBetweenAreBridged) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 20; ++pair) run(pair);
  const std::int64_t id = objects.objects.front().id;
  for (int pair = 20; pair < 25; ++pair) run(pair, EstimateStatus::kFailed);
  EXPECT_TRUE(objects.has_run);
  EXPECT_EQ(moving(), 0);
  for (int pair = 25; pair < 28; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_EQ(objects.objects.front().id, id);
}

TEST_F(Filter, RejectedPairsShowWhatIsKnownPredicted) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 20; ++pair) run(pair);
  const MovingObject before = objects.objects.front();
  reject(20);
  EXPECT_TRUE(objects.has_run);
  ASSERT_EQ(count(ObjectState::kCoasting), 1);
  const MovingObject& now = objects.objects.front();
  EXPECT_EQ(now.points, 0);
  EXPECT_NEAR(now.position_m.x() - before.position_m.x(), 0.5 / world.rate_hz, 2e-3);
  EXPECT_NEAR(now.rectangle.u_min_px - before.rectangle.u_min_px, 525.0 * 0.1 / world.rate_hz, 0.3);
  run(21);
  ASSERT_EQ(moving(), 1);
  EXPECT_EQ(objects.objects.front().id, before.id);
}

TEST_F(Filter, WhatIsNotSeenAgainEndsAlsoWhilePairsAreRejected) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  int pair = 0;
  for (; pair < 20; ++pair) run(pair);
  for (; pair < 20 + 59; ++pair) reject(pair);
  ASSERT_EQ(count(ObjectState::kCoasting), 1);
  for (; pair < 20 + 62; ++pair) reject(pair);
  EXPECT_TRUE(objects.objects.empty());
  // Its points belong to nobody then.
  run(pair);
  for (const PointMotion& point : objects.points) {
    const bool known =
        std::any_of(objects.objects.begin(), objects.objects.end(),
                    [&](const auto& object) { return object.id == point.object_id; });
    EXPECT_TRUE(point.object_id == 0 || known) << point.object_id;
  }
}

TEST_F(Filter, RectangleOfWhatIsPredictedOutOfViewIsEmpty) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {2.0, 0.1, 4.0}, {0.5, 0.5, 0.4}, {1.5, 0.0, 0.0});
  bool was_out_of_view = false;
  for (int pair = 0; pair < 60; ++pair) {
    run(pair);
    for (const MovingObject& object : objects.objects) {
      const bool empty = object.rectangle.u_max_px < object.rectangle.u_min_px;
      was_out_of_view = was_out_of_view || empty;
      EXPECT_TRUE(empty ||
                  (object.rectangle.u_min_px >= 0.0F &&
                   object.rectangle.u_max_px < static_cast<float>(synthetic::kCamera.width_px)));
      EXPECT_TRUE(object.state != ObjectState::kMoving || !empty);
    }
  }
  EXPECT_TRUE(was_out_of_view);
}

TEST_F(Filter, CovariancesStayCovariances) {
  world.rig_velocity_mps = {0.0, 0.0, 0.3};
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(200, 15.0, 30.0);
  world.add_box(40, {-0.3, 0.1, 1.5}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.3});
  int measured = 0;
  for (int pair = 0; pair < 900; ++pair) {
    run(pair);
    for (const MovingObject& object : objects.objects) {
      for (const Eigen::Matrix3d& C :
           {object.position_covariance_m2, object.velocity_covariance_m2ps2}) {
        ++measured;
        ASSERT_LT((C - C.transpose()).norm(), 1e-9 * C.norm()) << "pair " << pair;
        ASSERT_GT(C.ldlt().vectorD().minCoeff(), 0.0) << "pair " << pair;
      }
    }
  }
  EXPECT_GT(measured, 200);
}

TEST_F(Filter, ResetForgetsThePast) {
  world.add_background(300);
  for (int pair = 0; pair < 20; ++pair) run(pair);
  // After the reset the pose starts elsewhere: compared with the past everything would fly.
  for (int pair = 20; pair < 50; ++pair) {
    const TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    motion.reset_count = 1;
    motion.T_first_current.translation().x() += 3.0;
    detector.detect(tracks, motion, objects);
    EXPECT_TRUE(objects.objects.empty());
  }
}

TEST_F(Filter, SlowAxialMotionFarAwayIsUnobservableAtFirst) {
  world.add_background(100, 20.0, 30.0);
  run(0);
  run(1);
  for (const PointMotion& point : objects.points) {
    EXPECT_EQ(point.state, PointState::kUnobservable);
  }
}

TEST_F(Filter, SameInputGivesTheSameBytes) {
  std::vector<double> speeds[2];
  for (auto& run_speeds : speeds) {
    World same(7);
    same.pixel_sigma = 0.2;
    same.disparity_sigma_px = 0.3;
    same.add_background(300);
    same.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
    MovingObjectDetector fresh({.method = MovingObjectsMethod::kFilter});
    for (int pair = 0; pair < 30; ++pair) {
      const TrackSet tracks = same.tracks(pair);
      fresh.detect(tracks, same.motion(tracks, pair), objects);
      for (const PointMotion& point : objects.points) run_speeds.push_back(point.velocity_mps.x());
    }
  }
  EXPECT_EQ(speeds[0], speeds[1]);
}

TEST_F(Filter, NothingThatIsNotFiniteLeaves) {
  world.add_background(300);
  world.add_box(40, {-0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int pair = 0; pair < 40; ++pair) {
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
