// SPDX-License-Identifier: Apache-2.0
#include "driven_base.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base_link.hpp"

namespace egomod::sim {
namespace {

constexpr double kExact = 1e-9;
constexpr double kTickError = 1e-4;  // of what is exact only at ticks
constexpr Floor kHall{.x_min_m = -50.0, .x_max_m = 50.0, .z_min_m = -50.0, .z_max_m = 50.0};

// Reaches a commanded speed within a tick.
Drive prompt() { return {.acceleration_mps2 = 1e6, .turn_acceleration_radps2 = 1e6, .lag_s = 0.0}; }

Drive without_lag() {
  Drive drive;
  drive.lag_s = 0.0;
  return drive;
}

TEST(DrivenBase, DrivesTheArcThatItIsTold) {
  DrivenBase base(prompt(), kHall, 1);
  base.accept({.linear_mps = 0.8, .angular_radps = 0.4});
  base.advance(10.0);
  const double t0 = DrivenBase::kTick_s;  // speeds rise within the first tick
  const BaseState from = base.at(8.0);
  EXPECT_NEAR(from.pose.heading_rad, -0.4 * (8.0 - 0.5 * t0), kExact);
  EXPECT_NEAR(from.way_m, 0.8 * (8.0 - 0.5 * t0), kExact);
  // A quarter of a circle of 2 m to the left, of which it does not matter where it begins.
  const BaseState to = base.at(8.0 + 0.125 * M_PI / 0.4);
  const double turn = 0.125 * M_PI;
  const double heading = from.pose.heading_rad;
  const double ahead = 2.0 * std::sin(turn);
  const double left = 2.0 * (1.0 - std::cos(turn));
  EXPECT_NEAR(to.pose.x_m, from.pose.x_m + ahead * std::sin(heading) - left * std::cos(heading),
              kExact);
  EXPECT_NEAR(to.pose.z_m, from.pose.z_m + ahead * std::cos(heading) + left * std::sin(heading),
              kExact);
}

TEST(DrivenBase, SpeedsUpAndBrakesAtItsLimits) {
  DrivenBase base(without_lag(), kHall, 1);
  base.accept({.linear_mps = 0.6, .until_s = 5.0});
  base.advance(2.0);
  EXPECT_NEAR(base.at(1.0).linear_mps, 0.3, kExact);
  EXPECT_NEAR(base.at(1.0).way_m, 0.5 * 0.3, kExact);
  EXPECT_NEAR(base.at(2.0).linear_mps, 0.6, kExact);
  base.advance(7.5);
  EXPECT_NEAR(base.at(6.0).linear_mps, 0.3, kExact);
  EXPECT_NEAR(base.at(7.5).linear_mps, 0.0, kExact);
  EXPECT_NEAR(base.at(7.5).way_m, 0.6 * 5.0, kExact);  // two ramps of 2 s, 3 s between them
}

TEST(DrivenBase, TurnsOnTheSpotCounterClockwise) {
  DrivenBase base(without_lag(), kHall, 1);
  base.accept({.angular_radps = 1.0});
  base.advance(2.0);
  const double ramp_s = 1.0 / base.drive().turn_acceleration_radps2;
  EXPECT_NEAR(base.at(2.0).pose.heading_rad, -(2.0 - 0.5 * ramp_s), 1e-3 * ramp_s);
  EXPECT_NEAR(base.at(2.0).pose.x_m, 0.0, kExact);
}

TEST(DrivenBase, IsNoFasterThanItCan) {
  Drive drive = prompt();
  drive.max_speed_mps = 0.5;
  DrivenBase base(drive, kHall, 1);
  base.accept({.linear_mps = -3.0, .angular_radps = 100.0});
  base.advance(1.0);
  EXPECT_NEAR(base.at(1.0).linear_mps, -0.5, kExact);
  EXPECT_NEAR(base.at(1.0).angular_radps, drive.max_turn_radps, kExact);
}

TEST(DrivenBase, LagsBehindItsController) {
  Drive drive = prompt();
  drive.lag_s = 0.2;
  DrivenBase base(drive, kHall, 1);
  base.accept({.linear_mps = 1.0});
  base.advance(1.0);
  EXPECT_NEAR(base.at(0.2).linear_mps, 1.0 - std::exp(-1.0), kExact);
  EXPECT_NEAR(base.at(1.0).way_m, 1.0 - 0.2 * (1.0 - std::exp(-5.0)), kTickError);
}

TEST(DrivenBase, TakesUpACommandAtItsTimeOrAtOnce) {
  DrivenBase base(prompt(), kHall, 1);
  base.advance(1.0);
  base.accept({.from_s = 0.2, .linear_mps = 1.0});
  base.accept({.from_s = 1.5, .linear_mps = -1.0});
  base.advance(2.0);
  EXPECT_EQ(base.at(0.99).linear_mps, 0.0);
  EXPECT_EQ(base.at(1.25).linear_mps, 1.0);
  EXPECT_EQ(base.at(1.75).linear_mps, -1.0);
  base.accept({.from_s = 0.5, .linear_mps = 0.25});
  base.advance(2.5);
  EXPECT_EQ(base.at(2.25).linear_mps, 0.25) << "late, but newer than what holds";
}

TEST(DrivenBase, DependsOnItsCommandsOnlyNotOnWhenItIsAskedToGoOn) {
  DrivenBase base(Drive{}, kHall, 1);
  DrivenBase other(Drive{}, kHall, 1);
  for (DrivenBase* one : {&base, &other}) {
    one->accept({.from_s = 0.3, .linear_mps = 0.5, .angular_radps = 0.3});
  }
  base.advance(2.0);
  for (int i = 1; i <= 60; ++i) other.advance(i / 30.0);
  EXPECT_EQ(base.at(2.0).pose.x_m, other.at(2.0).pose.x_m);
  EXPECT_EQ(base.at(2.0).pose.z_m, other.at(2.0).pose.z_m);
}

TEST(DrivenBase, StallsAtAWallUntilItBacksOff) {
  DrivenBase base(prompt(), {.x_min_m = -2.0, .x_max_m = 2.0, .z_min_m = -1.0, .z_max_m = 3.0}, 1);
  base.accept({.linear_mps = 1.0});
  base.accept({.from_s = 4.0, .linear_mps = -1.0});
  base.advance(5.0);
  EXPECT_FALSE(base.at(2.0).stalled);
  EXPECT_TRUE(base.at(3.5).stalled);
  EXPECT_NEAR(base.at(3.5).pose.z_m, 3.0 - base.drive().radius_m, 0.01);
  EXPECT_FALSE(base.at(4.5).stalled);
  EXPECT_LT(base.at(5.0).pose.z_m, 2.0);
}

TEST(DrivenBase, CountsItsWheels) {
  Drive slipping = prompt();
  slipping.wheel_slip = 0.2;
  DrivenBase exact(prompt(), kHall, 1);
  DrivenBase base(slipping, kHall, 1);
  for (DrivenBase* one : {&exact, &base}) {
    one->accept({.linear_mps = 1.0});
    one->accept({.from_s = 2.0, .linear_mps = 1.0, .angular_radps = 0.5});
    one->advance(3.0);
  }
  const BaseState truth = exact.at(3.0);
  EXPECT_NEAR(truth.odometry_x_m, truth.pose.z_m, kTickError);
  EXPECT_NEAR(truth.odometry_y_m, -truth.pose.x_m, kTickError);
  EXPECT_NEAR(truth.odometry_heading_rad, -truth.pose.heading_rad, kExact);
  EXPECT_NEAR(base.at(2.0).odometry_x_m, exact.at(2.0).pose.z_m / 0.8, kExact);
}

TEST(DrivenBase, KnowsItsCountBetweenTicksToo) {
  DrivenBase base(prompt(), kHall, 1);
  base.accept({.linear_mps = 0.8});
  base.advance(2.0);
  for (const double t_s : {1.0, 1.0012, 1.0033, 1.0049}) {
    EXPECT_NEAR(base.at(t_s).odometry_x_m, base.at(t_s).way_m, kExact) << t_s;
  }
}

TEST(DrivenBase, CountsWithNoiseThatGrowsWithTheRootOfTheWay) {
  Drive drive = prompt();
  drive.wheel_noise_m_per_sqrt_m = 0.01;
  double square_sum_m2 = 0.0;
  constexpr int kRuns = 200;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    DrivenBase base(drive, kHall, seed);
    base.accept({.linear_mps = 1.0});
    base.advance(4.0);
    const BaseState state = base.at(4.0);
    const double error_rad = state.odometry_heading_rad + state.pose.heading_rad;
    square_sum_m2 += std::pow(error_rad * drive.wheel_track_m, 2);
  }
  // Two wheels of 4 m each; the sum of 200 squares is within 30 % of its mean.
  EXPECT_NEAR(square_sum_m2 / kRuns, 2.0 * 4.0 * 1e-4, 0.3 * 8e-4);
}

class Commands : public ::testing::Test {
 protected:
  static command_t message(std::int64_t sequence, std::int64_t utime = 0) {
    return {.utime = utime, .sequence = sequence, .linear = 0.5, .angular = 0.1, .valid_for = 0.5};
  }
  CommandReader reader_{2.0};
};

TEST_F(Commands, HoldFromTheSimulatedTimeThatTheyName) {
  const auto command = reader_.read(message(1, 3'000'000), 2.0);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->from_s, 3.0, kExact);
  EXPECT_NEAR(command->until_s, 3.5, kExact);
  EXPECT_EQ(command->linear_mps, 0.5);
}

TEST_F(Commands, HoldFromTheirArrivalWhenTheirClockIsAnother) {
  const auto command = reader_.read(message(1, 1'700'000'000'000'000), 2.0);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->from_s, 2.0, kExact);
  EXPECT_NEAR(command->until_s, 2.5, kExact);
}

TEST_F(Commands, HoldNoLongerThanTheWatchdogLets) {
  command_t endless = message(1);
  endless.valid_for = 1000.0;
  EXPECT_NEAR(reader_.read(endless, 0.0)->until_s, 2.0, kExact);
}

TEST_F(Commands, AreIgnoredUnlessTheyAreNewerThanWhatHolds) {
  EXPECT_TRUE(reader_.read(message(5), 0.0));
  EXPECT_FALSE(reader_.read(message(5), 0.1));
  EXPECT_FALSE(reader_.read(message(4), 0.1));
  EXPECT_TRUE(reader_.read(message(6), 0.1));
  EXPECT_TRUE(reader_.read(message(1, 3'000'000), 3.0)) << "a commander that was started again";
}

TEST_F(Commands, AreIgnoredUnlessTheyAreFinite) {
  command_t bad = message(1);
  bad.angular = std::nan("");
  EXPECT_FALSE(reader_.read(bad, 0.0));
}

}  // namespace
}  // namespace egomod::sim
