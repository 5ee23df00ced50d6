// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/lost_objects.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace egomod {
namespace {

using Eigen::Vector3d;

constexpr Nanoseconds after(double seconds) {
  return Nanoseconds{static_cast<std::int64_t>(seconds * 1e9)};
}

// Crosses at 5 m to the right with 0.5 m/s, last seen half a metre to the left.
LostObject crossing(std::int64_t id = 7) {
  return {.id = id,
          .first_seen = after(0.0),
          .last_seen = after(0.0),
          .centre_m = {-0.5, 0.0, 5.0},
          .velocity_mps = {0.5, 0.0, 0.0}};
}

LostObject standing() {
  LostObject object = crossing();
  object.velocity_mps.setZero();
  return object;
}

class Lost : public ::testing::Test {
 protected:
  void pass(double until_s,
            const Eigen::Isometry3d& T_current_previous = Eigen::Isometry3d::Identity()) {
    lost.move_on(after(until_s), T_current_previous);
  }
  // Who it may be there; nobody takes the name.
  std::int64_t at(const Vector3d& centre_m, const Vector3d& velocity_mps = {0.5, 0.0, 0.0}) {
    const auto object = lost.take(centre_m, velocity_mps);
    if (object) lost.give_back(object->id);
    return object ? object->id : 0;
  }
  LostObjects lost;
};

TEST_F(Lost, IsFoundWhereItsVelocityHasBroughtIt) {
  lost.remember(crossing());
  pass(3.0);
  EXPECT_EQ(at({1.0, 0.0, 5.0}), 7);
  EXPECT_EQ(at({1.0, 0.0, 9.0}), 0);
  EXPECT_EQ(at({-5.0, 0.0, 5.0}), 0);
}

TEST_F(Lost, IsNotWhoComesTheOtherWay) {
  lost.remember(crossing());
  pass(0.5);
  EXPECT_EQ(at({-0.25, 0.0, 5.0}, {-0.5, 0.0, 0.0}), 0);
  pass(3.5);
  EXPECT_EQ(at({1.25, 0.0, 5.0}, {-0.1, 0.0, 0.1}), 0) << "however long it was unseen";
}

TEST_F(Lost, IsNobodyFarAwayOrFarFasterHoweverLongItWasUnseen) {
  lost.remember(crossing());
  pass(3.9);
  EXPECT_EQ(at({1.45, 0.0, 6.9}), 7);
  EXPECT_EQ(at({1.45, 0.0, 7.1}), 0);
  EXPECT_EQ(at({1.45, 0.0, 5.0}, {1.6, 0.0, 0.0}), 0);
}

TEST_F(Lost, NameIsNobodysWhileSomebodyHasIt) {
  lost.remember(crossing());
  pass(1.0);
  ASSERT_TRUE(lost.take({0.0, 0.0, 5.0}, {0.5, 0.0, 0.0}));
  EXPECT_FALSE(lost.take({0.0, 0.0, 5.0}, {0.5, 0.0, 0.0}));
  lost.give_back(7);
  EXPECT_TRUE(lost.take({0.0, 0.0, 5.0}, {0.5, 0.0, 0.0}));
}

TEST_F(Lost, NobodyIsRememberedWhereTimeStepsBack) {
  pass(10.0);
  lost.remember(standing());
  pass(9.0);
  EXPECT_EQ(at({-0.5, 0.0, 5.0}), 0);
}

TEST_F(Lost, MayHaveTurnedMoreTheLongerItWasUnseen) {
  lost.remember(crossing());
  pass(0.2);
  EXPECT_EQ(at({-0.4, 0.0, 5.0}, {0.5, 0.0, 0.6}), 0);
  pass(2.5);
  EXPECT_EQ(at({0.75, 0.0, 5.0}, {0.5, 0.0, 0.7}), 7);
}

TEST_F(Lost, StaysInTheWorldWhileTheRigMoves) {
  lost.remember(standing());
  Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
  T_current_previous.translation() = Vector3d(0.0, 0.0, -2.0);
  pass(1.0, T_current_previous);
  EXPECT_EQ(at({-0.5, 0.0, 3.0}), 7);
  EXPECT_EQ(at({-0.5, 0.0, 5.0}), 0);
}

TEST_F(Lost, OneThatStoppedSetsOffAtAnySpeedAndIsKeptForLonger) {
  lost.remember(standing());
  pass(30.0);
  EXPECT_EQ(at({-0.5, 0.0, 5.0}, {0.0, 0.0, -2.0}), 7);
  pass(61.0);
  EXPECT_EQ(at({-0.5, 0.0, 5.0}), 0);
}

TEST_F(Lost, OneThatMovedIsForgottenWhenItMayBeAnywhere) {
  lost.remember(crossing());
  pass(4.1);
  EXPECT_EQ(at({1.55, 0.0, 5.0}), 0);
}

TEST_F(Lost, TheNearestIsTaken) {
  LostObject behind = crossing(8);
  behind.centre_m.z() = 5.6;
  lost.remember(crossing());
  lost.remember(behind);
  pass(1.0);
  EXPECT_EQ(at({0.0, 0.0, 5.1}), 7);
  EXPECT_EQ(at({0.0, 0.0, 5.5}), 8);
  lost.erase(8);
  EXPECT_EQ(at({0.0, 0.0, 5.5}), 7);
}

TEST_F(Lost, TheOldestMakesRoom) {
  lost.remember(crossing(1));
  for (std::int64_t id = 2; id <= 40; ++id) {
    LostObject other = crossing(id);
    other.centre_m.z() = 100.0;
    lost.remember(other);
  }
  pass(0.1);
  EXPECT_EQ(at({-0.45, 0.0, 5.0}), 0);
  EXPECT_EQ(at({-0.45, 0.0, 100.0}), 9) << "32 are kept";
}

}  // namespace
}  // namespace egomod
