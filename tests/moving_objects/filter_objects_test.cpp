// SPDX-License-Identifier: Apache-2.0
// Which tracks make an object, and which make none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "filter_fixture.hpp"

namespace egomod {
namespace {

TEST_F(Filter, TwoSideBySideWithOneVelocityStayTwo) {
  world.add_background(300);
  world.add_box(40, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(40, {0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.4});
  for (int pair = 0; pair < 40; ++pair) run(pair);
  EXPECT_EQ(moving(), 2);
}

// For some pairs points between them move alike, as where one sets off beside the other.
TEST_F(Filter, TwoThatWereTakenForOneAreToldApart) {
  world.add_background(300);
  world.add_box(40, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(40, {0.5, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(20, {-0.15, 0.1, 5.0}, {0.8, 0.5, 0.4}, {0.0, 0.0, 0.4});
  int pair = 0;
  for (; pair < 20; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  for (std::size_t i = 380; i < 400; ++i) world.points[i].at_start_m.y() += 50.0;
  for (; pair < 40; ++pair) run(pair);
  EXPECT_EQ(moving(), 2);
}

// Of the other one too few points are left for an object: they stretch the first one no longer.
TEST_F(Filter, WhatStandsApartIsNoPart) {
  rest_rig();
  world.add_background(900);
  world.add_box(40, {-0.8, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(4, {0.5, 0.1, 5.0}, {0.3, 0.5, 0.0}, {0.0, 0.0, 0.4});
  world.add_box(20, {-0.15, 0.1, 5.0}, {0.8, 0.5, 0.4}, {0.0, 0.0, 0.4});
  int pair = 0;
  for (; pair < 20; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_GT(objects.objects.front().extent_m.x(), 1.0);
  for (std::size_t i = 944; i < 964; ++i) world.points[i].at_start_m.y() += 50.0;
  for (; pair < 40; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_LT(objects.objects.front().extent_m.x(), 0.7);
}

// Something nearer hides its middle: nothing behind it shows there.
TEST_F(Filter, OneWhoseMiddleIsHiddenStaysOne) {
  rest_rig();
  world.add_background(300, 9.0, 12.0);
  world.add_box(40, {-0.75, 0.1, 5.0}, {0.6, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(40, {0.75, 0.1, 5.0}, {0.6, 0.5, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(40, {0.0, 0.1, 5.0}, {1.0, 0.5, 0.4}, {0.0, 0.0, 0.4});
  int pair = 0;
  for (; pair < 40; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  for (std::size_t i = 0; i < world.points.size(); ++i) {
    Eigen::Vector3d& at_m = world.points[i].at_start_m;
    if (i >= 380 || (i < 300 && std::abs(at_m.x()) < 0.12 * at_m.z())) at_m.y() += 50.0;
  }
  for (; pair < 60; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

TEST_F(Filter, OverlappingObjectsAreSplitByVelocity) {
  world.add_background(300);
  world.add_box(30, {0.0, 0.1, 5.0}, {0.4, 0.5, 0.4}, {0.5, 0.0, 0.0});
  world.add_box(30, {0.0, 0.1, 5.0}, {0.4, 0.5, 0.4}, {-0.5, 0.0, 0.0});
  for (int pair = 0; pair < 15; ++pair) run(pair);
  EXPECT_EQ(moving(), 2);
}

TEST_F(Filter, IslandsOfOneLargeBodyAreOneObject) {
  world.rate_hz = 10.0;
  world.add_background(300, 20.0, 30.0);
  world.add_box(30, {1.0, 0.5, 8.0}, {0.6, 1.2, 1.5}, {0.0, 0.0, 6.0});
  world.add_box(30, {2.2, 0.5, 8.5}, {0.6, 1.2, 3.0}, {0.0, 0.0, 6.0});
  for (int pair = 0; pair < 8; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

// A part of one that was taken for an older object is no reason to call all of it by that name.
TEST_F(Filter, TheLargerOfTwoThatBecomeOneKeepsItsName) {
  rest_rig();
  world.add_background(300);
  world.add_box(8, {-1.6, 0.1, 4.0}, {0.2, 0.4, 0.1}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 20; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const std::int64_t older = moving_id();
  const Eigen::Vector3d velocity_mps{0.5, 0.0, 0.4};
  world.add_box(50, {-1.0, 0.1, 2.4}, {0.6, 0.6, 0.1}, velocity_mps);
  int pair = 20;
  for (; pair < 80; ++pair) run(pair);
  ASSERT_EQ(moving(), 2);
  for (std::size_t i = 300; i < 308; ++i) {
    world.points[i].at_start_m +=
        world.time_s(pair) * (world.points[i].velocity_mps - velocity_mps);
    world.points[i].velocity_mps = velocity_mps;
  }
  for (; pair < 110; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_NE(moving_id(), older);
}

// Its other end was found while the middle was not seen yet.
TEST_F(Filter, PartFoundBesideWhatIsConfirmedJoinsIt) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d velocity_mps{0.5, 0.0, 0.0};
  const Eigen::Vector3d size_m{0.3, 0.5, 0.1};
  const Eigen::Vector3d hidden_m{0.0, 50.0, 0.0};
  world.add_box(10, {-1.4, 0.1, 4.0}, size_m, velocity_mps);
  world.add_box(15, hidden_m + Eigen::Vector3d(-0.4, 0.1, 4.0), size_m, velocity_mps);
  world.add_box(10, hidden_m + Eigen::Vector3d(-0.9, 0.1, 4.0), {0.6, 0.5, 0.1}, velocity_mps);
  const auto show = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) world.points[i].at_start_m -= hidden_m;
  };
  for (int pair = 0; pair < 20; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const std::int64_t id = moving_id();
  show(310, 325);
  run(20);
  show(325, 335);
  for (int pair = 21; pair < 30; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_EQ(moving_id(), id);
}

// Near enough for their size to be islands of one body, but what rests behind shows between them.
TEST_F(Filter, TwoThatAreSeenPastStayTwo) {
  world.add_background(600, 9.0, 12.0);
  world.add_box(60, {-0.5, 0.1, 5.0}, {0.5, 1.6, 0.4}, {0.0, 0.0, 0.4});
  world.add_box(60, {0.5, 0.1, 5.0}, {0.5, 1.6, 0.4}, {0.0, 0.0, 0.4});
  for (int pair = 0; pair < 40; ++pair) run(pair);
  EXPECT_EQ(moving(), 2);
}

TEST_F(Filter, EchoOfRepeatedTextureIsNoObject) {
  world.rig_velocity_mps = {0.0, 0.0, 0.3};
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(600, 9.5, 10.5);
  // Matched one period off: at a fifth of its depth it seems to follow the rig.
  world.add_box(12, {0.0, 0.0, 2.0}, {0.2, 0.2, 0.02}, {0.0, 0.0, 0.8 * 0.3});
  for (int pair = 0; pair < 60; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

TEST_F(Filter, WhatIsKnownForLongIsNoEchoWhenItMovesLikeOne) {
  world.rig_velocity_mps = {0.0, 0.0, 0.3};
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(600, 9.5, 10.5);
  world.add_box(12, {-0.6, 0.0, 2.0}, {0.2, 0.2, 0.02}, {0.3, 0.0, 0.8 * 0.3});
  int pair = 0;
  for (; pair < 45; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const std::int64_t id = objects.objects.front().id;
  turn(pair - 1, 600, {0.0, 0.0, 0.8 * 0.3});
  for (; pair < 90; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_EQ(objects.objects.front().id, id);
}

TEST_F(Filter, EchoOfAMoversTextureIsNoObject) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-0.5, 0.0, 2.0}, {0.6, 0.6, 0.02}, {0.6, 0.0, 0.0});
  // Matched wrong: it crosses the image like the mover, at one and a half times its depth.
  world.add_box(8, {-0.75, 0.0, 3.0}, {0.3, 0.3, 0.02}, {0.9, 0.0, 0.0});
  for (int pair = 0; pair < 40; ++pair) {
    run(pair);
    ASSERT_LE(moving(), 1) << "pair " << pair;
  }
  EXPECT_EQ(moving(), 1);
}

TEST_F(Filter, BorderThatOnlyChangesItsDepthIsNoObject) {
  rest_rig();
  world.add_background(300);
  world.add_box(10, {-1.0, 0.0, 4.0}, {0.0, 1.2, 0.0}, {0.0, 0.0, 0.5});
  for (int pair = 0; pair < 40; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

// Lines that lie across the image tell little of where along them a point is.
class FilterOnGrain : public Filter {
 protected:
  FilterOnGrain() {
    world.rig_velocity_mps = {0.2, 0.0, 0.1};
    world.add_background(300);
  }
  int moving_after(int pairs) {
    int most = 0;
    for (int pair = 0; pair < pairs; ++pair) {
      TrackSet tracks = world.tracks(pair);
      for (Track& track : tracks.tracks) {
        if (!world.points[track.id - 1].velocity_mps.isZero())
          track.current.covariance_px2[0] *= 4.0F;
      }
      detector.detect(tracks, world.motion(tracks, pair), objects);
      most = std::max(most, moving());
    }
    return most;
  }
};

TEST_F(FilterOnGrain, WhatSlipsAlongItIsNoObject) {
  world.add_box(30, {0.0, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.3, 0.0, 0.0});
  EXPECT_EQ(moving_after(30), 0);
}

TEST_F(FilterOnGrain, WhatMovesAlongItFastIsAnObject) {
  world.add_box(30, {0.0, 0.1, 5.0}, {0.5, 0.5, 0.4}, {1.0, 0.0, 0.0});
  EXPECT_EQ(moving_after(15), 1);
}

TEST_F(FilterOnGrain, WhatMovesAcrossItIsAnObject) {
  world.add_box(30, {0.0, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.3, 0.3, 0.0});
  EXPECT_EQ(moving_after(30), 1);
}

// Few points of one velocity on the trunk; legs swing to and fro, once in 1.2 s.
TEST_F(Filter, WalkerIsOneObject) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d walk_mps{1.0, 0.0, 0.1};
  world.add_box(4, {-2.2, -0.3, 6.0}, {0.4, 0.4, 0.2}, walk_mps);
  world.add_box(3, {-2.2, 0.3, 6.0}, {0.1, 0.3, 0.1}, walk_mps);
  world.add_box(3, {-2.2, 0.3, 6.0}, {0.1, 0.3, 0.1}, walk_mps);
  int seen = 0;
  for (int pair = 0; pair < 90; ++pair) {
    const double swing_mps = 0.9 * std::sin(2.0 * M_PI * world.time_s(pair) / 1.2);
    turn(pair, 307, walk_mps - Eigen::Vector3d(swing_mps, 0.0, 0.0));
    for (std::size_t i = 304; i < 307; ++i) {
      synthetic::Point& point = world.points[i];
      const Eigen::Vector3d now_mps = walk_mps + Eigen::Vector3d(swing_mps, 0.0, 0.0);
      point.at_start_m += world.time_s(pair) * (point.velocity_mps - now_mps);
      point.velocity_mps = now_mps;
    }
    run(pair);
    ASSERT_LE(moving(), 1) << "pair " << pair;
    seen += moving();
  }
  EXPECT_GT(seen, 70);
  EXPECT_LT((objects.objects.front().velocity_mps - walk_mps).norm(), 0.15);
}

// In the middle of a step no five points have one velocity.
TEST_F(Filter, WalkerInMidStepIsFoundWithItsLegs) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d walk_mps{1.0, 0.0, 0.1};
  const Eigen::Vector3d swing_mps{0.6, 0.0, 0.0};
  world.add_box(4, {-1.2, -0.3, 6.0}, {0.4, 0.4, 0.2}, walk_mps);
  world.add_box(3, {-1.3, 0.3, 6.0}, {0.1, 0.3, 0.1}, walk_mps + swing_mps);
  world.add_box(3, {-1.1, 0.3, 6.0}, {0.1, 0.3, 0.1}, walk_mps - swing_mps);
  for (int pair = 0; pair < 18; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_GE(objects.objects.front().points, 9);
  EXPECT_LT((objects.objects.front().velocity_mps - walk_mps).norm(), 0.15);
}

// A trunk, and below it points that move otherwise, too few of one velocity for a group.
class FilterOnTrunk : public Filter {
 protected:
  // How far below the trunk's lowest point the rectangle reaches, m.
  double reach_below(const Eigen::Vector3d& trunk_m) {
    rest_rig();
    world.add_background(300);
    const Eigen::Vector3d walk_mps{0.8, 0.0, 0.0};
    const Eigen::Vector3d swing_mps{0.4, 0.0, 0.0};
    const double depth_m = 6.0;
    world.add_box(60, {-1.0, 0.0, depth_m}, trunk_m, walk_mps);
    const double below_m = 0.5 * trunk_m.y() + 0.5;
    world.add_box(3, {-1.0, below_m, depth_m}, {0.1, 0.4, 0.1}, walk_mps + swing_mps);
    world.add_box(3, {-1.0, below_m, depth_m}, {0.1, 0.4, 0.1}, walk_mps - swing_mps);
    for (int pair = 0; pair < 18; ++pair) run(pair);
    EXPECT_EQ(moving(), 1);
    const MovingObject& object = objects.objects.front();
    EXPECT_LT((object.velocity_mps - walk_mps).norm(), 0.1);
    const StereoCamera& camera = synthetic::kCamera;
    return (object.rectangle.v_max_px - camera.cy_px) / camera.fy_px * depth_m - 0.5 * trunk_m.y();
  }
};

TEST_F(FilterOnTrunk, WalkersLegsAreInItsOutline) { EXPECT_GT(reach_below({0.4, 0.7, 0.2}), 0.4); }

TEST_F(FilterOnTrunk, WhatMovesBelowALargeBodyIsNot) {
  EXPECT_LT(reach_below({1.8, 0.7, 0.2}), 0.1);
}

// More than half as many points as the trunk shows, once the trunk has been known for a second.
TEST_F(Filter, ArmThatBeginsToSwingIsNoObject) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d walk_mps{0.4, 0.0, 0.0};
  world.add_box(10, {-1.0, 0.0, 5.0}, {0.4, 0.9, 0.2}, walk_mps);
  world.add_box(7, {-1.0, 0.1, 4.8}, {0.1, 0.5, 0.1}, walk_mps);
  int pair = 0;
  for (; pair < 45; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  turn(pair - 1, 310, {0.9, 0.0, 0.0});
  expect_one_at_most(pair, 65);
  EXPECT_EQ(moving(), 1);
}

// Three points of it are no line yet, but all that move there are.
TEST_F(Filter, EdgeThatSlipsInPiecesIsNoObject) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d slip_mps{0.0, 0.15, 0.0};
  world.add_box(3, {0.9, -0.8, 3.0}, {0.06, 0.1, 0.02}, slip_mps);
  for (const double y_m : {-0.3, 0.2, 0.7, 1.2})
    world.add_box(1, {0.9, y_m, 3.0}, {0.02, 0.02, 0.02}, slip_mps);
  for (int pair = 0; pair < 60; ++pair) {
    run(pair);
    ASSERT_EQ(moving(), 0) << "pair " << pair;
  }
}

// A thing that moves at the left border, which may be a look-alike where something near, that rests
// to the right of it, is too near for the right camera there.
struct AtLeftBorder : Filter {
  int moving_beside_what_rests_at(double depth_m) {
    rest_rig();
    world.add_background(300);
    const double at_130_px = (130.0 - synthetic::kCamera.cx_px) / synthetic::kCamera.fx_px;
    world.add_box(12, {at_130_px * depth_m, -0.1, depth_m}, {0.05, 0.3, 0.05},
                  Eigen::Vector3d::Zero());
    world.add_box(12, {-1.45, 0.0, 3.4}, {0.15, 0.3, 0.1}, {0.0, 0.2, 0.3});
    for (int pair = 0; pair < 20; ++pair) run(pair);
    return moving();
  }
};

TEST_F(AtLeftBorder, IsAnObjectBesideWhatBothCamerasSee) {
  EXPECT_EQ(moving_beside_what_rests_at(3.0), 1);
}

TEST_F(AtLeftBorder, IsNoneBesideWhatOnlyTheLeftOneSees) {
  EXPECT_EQ(moving_beside_what_rests_at(1.5), 0);
}

// Of a person in plain clothes there may be no more to be seen than the head and a shoe.
TEST_F(Filter, FootThatStepsFarBelowAHeadIsNoObject) {
  rest_rig();
  world.add_background(300);
  world.add_box(6, {-1.0, -0.8, 5.0}, {0.18, 0.2, 0.15}, {0.4, 0.0, 0.0});
  world.add_box(7, {-0.4, 0.7, 5.0}, {0.2, 0.1, 0.2}, Eigen::Vector3d::Zero());
  int pair = 0;
  for (; pair < 40; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  turn(pair - 1, 306, {0.9, 0.0, 0.0});
  expect_one_at_most(pair, 55);
  EXPECT_EQ(moving(), 1);
}

TEST_F(Filter, HeadHighAboveLegsOfItsVelocityIsOneWithThem) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d walk_mps{0.6, 0.0, 0.0};
  world.add_box(8, {-1.0, -0.8, 5.0}, {0.18, 0.2, 0.15}, walk_mps);
  world.add_box(12, {-1.0, 0.2, 5.0}, {0.3, 0.7, 0.2}, walk_mps);
  for (int pair = 0; pair < 30; ++pair) run(pair);
  EXPECT_EQ(moving(), 1);
}

TEST_F(Filter, ArmBesideItsTrunkIsNoObject) {
  rest_rig();
  world.add_background(300);
  const Eigen::Vector3d walk_mps{0.8, 0.0, 0.0};
  world.add_box(30, {-1.0, 0.0, 5.0}, {0.4, 0.9, 0.2}, walk_mps);
  world.add_box(7, {-0.9, 0.1, 4.9}, {0.1, 0.5, 0.1}, {1.3, 0.0, 0.0});
  expect_one_at_most(0, 15);
  EXPECT_EQ(moving(), 1);
}

// Trunk and legs, which swing; then the trunk is hidden, and the legs' velocities are not its own.
TEST_F(Filter, VelocityOfAWalkerDoesNotLeapToThatOfALeg) {
  rest_rig();
  world.add_background(300);
  world.add_box(4, {-2.0, 0.0, 5.0}, {0.3, 0.5, 0.2}, {1.2, 0.0, 0.0});
  world.add_box(4, {-2.0, 0.7, 5.0}, {0.3, 0.6, 0.2}, {0.2, 0.0, 0.0});
  int pair = 0;
  for (; pair < 42; ++pair) {
    if (pair % 6 == 3) turn(pair - 1, 304, {pair % 12 == 3 ? 2.2 : 0.2, 0.0, 0.0});
    run(pair);
  }
  ASSERT_EQ(moving(), 1);
  EXPECT_NEAR(objects.objects.front().velocity_mps.x(), 1.2, 0.3);
  for (std::size_t i = 300; i < 304; ++i) world.points[i].at_start_m.y() += 50.0;
  turn(pair - 1, 304, {3.0, 0.0, 0.0});
  for (; pair < 48; ++pair) {
    run(pair);
    ASSERT_FALSE(objects.objects.empty());
    EXPECT_NEAR(objects.objects.front().velocity_mps.x(), 1.2, 0.5) << pair;
  }
}

// It takes longer, but a point that surely moves is told without an object.
TEST_F(Filter, PointOfNoObjectIsToldAsMovingOnlyIfItSurelyDoes) {
  rest_rig();
  world.add_background(300);
  world.add_box(1, {-0.5, 0.1, 5.0}, {0.01, 0.01, 0.01}, {0.15, 0.0, 0.0});
  const auto mover_moves = [&](int pair) {
    run(pair);
    const std::uint64_t mover = world.tracks(pair).tracks[300].id;
    bool told = false;
    for (const PointMotion& point : objects.points) {
      if (point.track_id != mover) continue;
      told = point.state == PointState::kMoving;
      EXPECT_EQ(point.object_id, 0);
      EXPECT_TRUE(!told || point.chi2 > 50.0F) << pair;
    }
    return told;
  };
  for (int pair = 0; pair < 45; ++pair) mover_moves(pair);
  EXPECT_TRUE(mover_moves(45));
}

// Far away the filters are behind by most of a second along the line of sight.
TEST_F(Filter, VelocityThatGrowsFarAwayIsNotFarBehind) {
  world.rig_yaw_rate_radps = 0.0;
  world.add_background(300);
  world.add_box(40, {0.0, 0.2, 6.0}, {0.6, 0.6, 0.3}, {0.05, 0.0, 0.4});
  double error_mps = 0.0;
  constexpr int kEnd = 180;
  constexpr int kCounted = 60;
  for (int pair = 0; pair < kEnd; ++pair) {
    const Eigen::Vector3d velocity_mps{0.05, 0.0, 0.4 + 0.1 * world.time_s(pair)};
    turn(pair, 300, velocity_mps);
    run(pair);
    if (pair < kEnd - kCounted) continue;
    ASSERT_EQ(moving(), 1) << "pair " << pair;
    error_mps += (objects.objects.front().velocity_mps.z() - velocity_mps.z()) / kCounted;
  }
  EXPECT_NEAR(error_mps, 0.0, 0.02);
}

// Most of somebody who is known goes behind something; what is left is few of its points.
class FilterOnFew : public Filter {
 protected:
  FilterOnFew() {
    rest_rig();
    world.add_background(kOthers);
    world.add_box(30, {-1.0, 0.2, 4.0}, {0.5, 0.6, 0.2}, velocity_mps_);
    for (; pair_ < 40; ++pair_) run(pair_);
    width_px_ = width_px();
  }
  void see(std::size_t points) {
    TrackSet tracks = world.tracks(pair_);
    std::erase_if(tracks.tracks, [&](const Track& track) { return track.id > kOthers + points; });
    detector.detect(tracks, world.motion(tracks, pair_), objects);
    ++pair_;
  }
  [[nodiscard]] float width_px() const {
    if (objects.objects.empty()) return 0.0F;
    const PixelRect& r = objects.objects.front().rectangle;
    return r.u_max_px - r.u_min_px;
  }

  static constexpr int kOthers = 300;
  const Eigen::Vector3d velocity_mps_{0.5, 0.0, 0.0};
  int pair_ = 0;
  float width_px_ = 0.0F;
};

TEST_F(FilterOnFew, TwoPointsThatMoveAsItWasDueToShowThatItGoesOn) {
  ASSERT_EQ(moving(), 1);
  for (int k = 0; k < 30; ++k) {
    see(2);
    ASSERT_EQ(moving(), 1) << k;
    EXPECT_EQ(objects.objects.front().points, 2);
    EXPECT_NEAR(width_px(), width_px_, 1.0F) << "few points do not tell its outline";
    EXPECT_LT((objects.objects.front().velocity_mps - velocity_mps_).norm(), 0.15);
  }
}

TEST_F(FilterOnFew, OnePointMayBeAMistake) {
  ASSERT_EQ(moving(), 1);
  see(1);
  EXPECT_EQ(count(ObjectState::kCoasting), 1);
}

TEST_F(FilterOnFew, TwoPointsThatMoveOtherwiseDoNot) {
  ASSERT_EQ(moving(), 1);
  turn(pair_ - 1, kOthers, {-0.8, 0.0, 0.0});
  for (int k = 0; k < 6; ++k) see(2);
  EXPECT_EQ(count(ObjectState::kCoasting), 1);
}

TEST_F(FilterOnFew, TwoPointsBesideAsManyThatRestDoNot) {
  ASSERT_EQ(moving(), 1);
  turn(pair_ - 1, kOthers + 2, Eigen::Vector3d::Zero());
  for (int k = 0; k < 12; ++k) see(5);
  EXPECT_EQ(moving(), 0);
}

}  // namespace
}  // namespace egomod
