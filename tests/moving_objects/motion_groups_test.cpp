// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/motion_groups.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "egomod/core/geometry.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;

// Three points that rest beside a group 3.4 m away at the left border, on something 1.6 m away: the
// right camera does not see it there, since its disparity is 123 px.
struct BesideALeg {
  MotionGroup group;
  std::vector<PointSample> points;

  BesideALeg() {
    group.position_m = {-1.4, 0.0, 3.4};
    group.rectangle = {80.0F, 200.0F, 112.0F, 240.0F};
    for (const double v_px : {205.0, 215.0, 225.0}) {
      PointSample point;
      point.stands = true;
      point.pixel_px = {130.0, v_px};
      point.position_m = {-0.5, 0.0, 1.6};
      points.push_back(point);
    }
  }
  [[nodiscard]] bool lies_on_unseen_border() const {
    return egomod::lies_on_unseen_border(kCamera, group, points);
  }
};

TEST(UnseenBorder, IsWhereSomethingNearLeavesTheRightImage) {
  EXPECT_TRUE(BesideALeg().lies_on_unseen_border());
}

TEST(UnseenBorder, IsNoneWhereTheRightCameraSeesWhatIsNear) {
  BesideALeg further_right;
  for (float* u_px :
       {&further_right.group.rectangle.u_min_px, &further_right.group.rectangle.u_max_px})
    *u_px += 60.0F;
  for (PointSample& point : further_right.points) point.pixel_px.x() += 60.0;
  EXPECT_FALSE(further_right.lies_on_unseen_border());
}

TEST(UnseenBorder, IsNoneBesideWhatIsAsFarAway) {
  BesideALeg beside_a_wall;
  for (PointSample& point : beside_a_wall.points) point.position_m.z() = 3.0;
  EXPECT_FALSE(beside_a_wall.lies_on_unseen_border());
}

// A floor 0.45 m below the camera, and a group as if seen through it, 5 m away.
struct UnderAFloor {
  MotionGroup group;
  std::vector<PointSample> points;

  UnderAFloor() {
    group.position_m = {0.5, 2.0, 5.0};
    group.rectangle = {350.0F, 420.0F, 400.0F, 450.0F};
    for (const double z_m : {1.1, 1.15, 1.2, 4.0, 5.0, 6.0}) add({0.0, 0.45, z_m});
  }
  void add(const Eigen::Vector3d& position_m) {
    PointSample point;
    point.stands = true;
    point.position_m = position_m;
    point.pixel_px = project(kCamera, position_m).head<2>();
    points.push_back(point);
  }
  [[nodiscard]] bool lies_under_ground() const { return egomod::lies_under_ground(group, points); }
};

TEST(Ground, NothingMovesUnderIt) { EXPECT_TRUE(UnderAFloor().lies_under_ground()); }

TEST(Ground, WhatStandsOnItMoves) {
  UnderAFloor on_it;
  on_it.group.position_m.y() = 0.3;
  EXPECT_FALSE(on_it.lies_under_ground());
}

TEST(Ground, IsAsLowAsWhatRestsThere) {
  UnderAFloor beside_stairs;
  for (int i = 0; i < 3; ++i) beside_stairs.add({0.0, 2.2, 5.0});
  EXPECT_FALSE(beside_stairs.lies_under_ground());
}

// A low mover on a floor without texture, below all that rests.
TEST(Ground, IsUnknownWhereNothingNearerIsSeenBelow) {
  UnderAFloor plain;
  for (PointSample& point : plain.points) point.pixel_px.y() = 300.0;
  EXPECT_FALSE(plain.lies_under_ground());
}

TEST(UnseenBorder, IsNoneAboveTheFloor) {
  BesideALeg above_the_floor;
  for (PointSample& point : above_the_floor.points) point.pixel_px.y() += 40.0;
  EXPECT_FALSE(above_the_floor.lies_on_unseen_border());
}

// Six points 3 m away, upright one above the other, to the left and to the right by turns.
LineMotion motion_of_upright_line(const Eigen::Vector3d& velocity_mps, double aside_m = 0.0) {
  std::vector<PointSample> points;
  std::vector<Grouper::Index> members;
  double x_m = aside_m;
  for (const double y_m : {-0.5, -0.3, -0.1, 0.1, 0.3, 0.5}) {
    PointSample point;
    point.position_m = {x_m, y_m, 3.0};
    x_m = -x_m;
    point.pixel_px = {320.0 + 525.0 * point.position_m.x() / 3.0, 240.0 + 525.0 * y_m / 3.0};
    point.velocity_mps = velocity_mps;
    members.push_back(static_cast<Grouper::Index>(points.size()));
    points.push_back(point);
  }
  return line_motion(kCamera, points, members);
}

TEST(LineMotion, OfAnEdgeThatSlipsIsThatOfABorder) {
  EXPECT_TRUE(motion_of_upright_line({0.06, 0.04, 0.0}).like_border);
  EXPECT_TRUE(motion_of_upright_line({0.2, 0.0, 0.3}).like_border);
}

TEST(LineMotion, OfAWiderOneIsAlongItOnlyWhereItIsSlow) {
  EXPECT_TRUE(motion_of_upright_line({0.0, 0.12, 0.0}, 0.07).along_line);
  EXPECT_FALSE(motion_of_upright_line({0.0, 0.4, 0.0}, 0.07).along_line);
  EXPECT_FALSE(motion_of_upright_line({0.0, 0.02, 0.0}, 0.07).like_border);
}

TEST(LineMotion, OfAPoleThatIsCarriedIsItsOwn) {
  const LineMotion carried = motion_of_upright_line({0.4, 0.1, 0.0});
  EXPECT_FALSE(carried.like_border);
  EXPECT_FALSE(carried.along_line);
  EXPECT_TRUE(motion_of_upright_line({0.02, 0.4, 0.0}).along_line);
}

}  // namespace
}  // namespace egomod
