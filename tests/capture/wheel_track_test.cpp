// SPDX-License-Identifier: Apache-2.0
#include "capture/wheel_track.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "message_fixture.hpp"

namespace egomod {
namespace {

constexpr double kMaxAge_s = 0.2;
constexpr double kExact = 1e-9;

Nanoseconds ms(std::int64_t time_ms) { return std::chrono::milliseconds(time_ms); }

// On a circle of 2 m to the left, at 0.5 m/s, 20 ms a reading.
WheelReading on_circle(double time_s, std::int64_t sequence) {
  const double heading = 3.0 + 0.25 * time_s;
  return {.time = Nanoseconds(std::llround(1e9 * time_s)),
          .sequence = sequence,
          .x_m = 2.0 * std::sin(heading),
          .y_m = -2.0 * std::cos(heading),
          .heading_rad = std::remainder(heading, 2.0 * std::numbers::pi)};
}

WheelTrack circle(int readings) {
  WheelTrack track(kMaxAge_s);
  for (int i = 0; i < readings; ++i) track.add(on_circle(0.02 * i, i));
  return track;
}

void expect_on_circle(const std::optional<WheelPose>& pose, double time_s) {
  ASSERT_TRUE(pose);
  const WheelReading truth = on_circle(time_s, 0);
  EXPECT_NEAR(pose->T_wheels_body.translation().x(), truth.x_m, kExact);
  EXPECT_NEAR(pose->T_wheels_body.translation().y(), truth.y_m, kExact);
  EXPECT_EQ(pose->T_wheels_body.translation().z(), 0.0);
  EXPECT_NEAR(pose->T_wheels_body(0, 0), std::cos(truth.heading_rad), kExact);
  EXPECT_NEAR(pose->T_wheels_body(1, 0), std::sin(truth.heading_rad), kExact);
}

TEST(WheelTrack, FollowsTheArcBetweenReadingsAlsoWhereTheHeadingWraps) {
  const WheelTrack track = circle(100);
  for (const double time_s : {0.0, 0.033, 0.5, 0.5661, 0.5663, 0.57, 1.979}) {
    expect_on_circle(track.at(Nanoseconds(std::llround(1e9 * time_s))), time_s);
  }
}

TEST(WheelTrack, GoesOnAlongTheLastArcForAShortTimeOnly) {
  const WheelTrack track = circle(10);
  expect_on_circle(track.at(ms(230)), 0.23);
  EXPECT_TRUE(track.at(ms(380)));
  EXPECT_FALSE(track.at(ms(381)));
}

TEST(WheelTrack, KnowsNothingBeforeItsFirstReadingNorFromOneAlone) {
  EXPECT_FALSE(WheelTrack(kMaxAge_s).at(ms(0)));
  WheelTrack track(kMaxAge_s);
  track.add(on_circle(0.02, 0));
  EXPECT_FALSE(track.at(ms(19)));
  EXPECT_TRUE(track.at(ms(20)));
  EXPECT_FALSE(track.at(ms(21)));
}

TEST(WheelTrack, JoinsNoReadingsOverAGap) {
  WheelTrack track = circle(2);
  track.add(on_circle(0.3, 2));
  EXPECT_FALSE(track.at(ms(100)));
  const auto before = track.at(ms(10));
  const auto after = track.at(ms(300));
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->stretch, after->stretch) << "the base went on counting";
}

TEST(WheelTrack, KeepsTheLastSecondsOnly) {
  const WheelTrack track = circle(1000);
  EXPECT_FALSE(track.at(ms(1000)));
  expect_on_circle(track.at(ms(15010)), 15.01);
}

TEST(WheelTrack, BeginsANewStretchWhenTheBaseStartsCountingAnew) {
  const auto stretch_after = [](WheelReading next) {
    WheelTrack track = circle(10);
    const std::uint32_t before = track.at(ms(180))->stretch;
    track.add(next);
    return track.at(next.time)->stretch - before;
  };
  EXPECT_EQ(stretch_after(on_circle(0.2, 10)), 0U);
  EXPECT_EQ(stretch_after(on_circle(0.2, 0)), 1U) << "its numbers do";
  WheelReading elsewhere = on_circle(0.2, 10);
  elsewhere.x_m += 2.0;
  EXPECT_EQ(stretch_after(elsewhere), 1U) << "it jumps";
  EXPECT_EQ(stretch_after(on_circle(-5.0, 10)), 1U) << "its clock steps back";
}

TEST(WheelTrack, LeavesOutWhatComesTwiceOrTooLate) {
  WheelTrack track = circle(10);
  WheelReading late = on_circle(0.1, 5);
  late.x_m += 0.1;
  track.add(late);
  expect_on_circle(track.at(ms(100)), 0.1);
  expect_on_circle(track.at(ms(170)), 0.17);
}

TEST(WheelTrack, ReadsNothingThatIsNoOdometry) {
  const auto message = encoded(odometry_at(1234, 5, 0.25));
  const auto reading = decode_odometry(message);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->time, std::chrono::microseconds(1234));
  EXPECT_EQ(reading->sequence, 5);
  EXPECT_EQ(reading->x_m, 0.25);
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(decode_odometry(std::span(message).first(size))) << size;
  }
  EXPECT_FALSE(
      decode_odometry(encoded(odometry_at(1234, 5, std::numeric_limits<double>::quiet_NaN()))));
  EXPECT_FALSE(
      decode_odometry(encoded(odometry_at(std::numeric_limits<std::int64_t>::max(), 5, 0.0))));
}

}  // namespace
}  // namespace egomod
