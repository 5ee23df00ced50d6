// SPDX-License-Identifier: Apache-2.0
#include "exposures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace egomod::sim {
namespace {

World world(const Timing& timing) {
  World out;
  out.duration_s = 60.0;
  out.rate_hz = 30.0;
  out.timing = timing;
  return out;
}

TEST(Exposures, OfBothCamerasCoincideByDefault) {
  const auto left = delivered(world({}), Eye::kLeft);
  const auto right = delivered(world({}), Eye::kRight);
  ASSERT_EQ(left.size(), 1800U);
  ASSERT_EQ(right.size(), 1800U);
  EXPECT_DOUBLE_EQ(left[7].t_s, 7 / 30.0);
  EXPECT_EQ(left[7].t_s, right[7].t_s);
  EXPECT_EQ(left[7].late_s, 0.0);
}

TEST(Exposures, OfATriggeredPairShareTheirJitter) {
  const World shaken = world({.jitter_s = 0.002});
  double square = 0.0;
  for (std::uint64_t number = 1; number < 1000; ++number) {
    const double t_s = exposure(shaken, Eye::kLeft, number).t_s;
    EXPECT_EQ(t_s, exposure(shaken, Eye::kRight, number).t_s);
    square += std::pow(t_s - static_cast<double>(number) / 30.0, 2);
  }
  EXPECT_NEAR(std::sqrt(square / 999.0), 0.002, 0.0002);
}

TEST(Exposures, OfAFreeRunningCameraDriftAway) {
  const World free = world({.right_offset_s = 0.004, .right_drift_ppm = 200.0});
  EXPECT_NEAR(exposure(free, Eye::kRight, 0).t_s, 0.004, 1e-12);
  EXPECT_NEAR(exposure(free, Eye::kRight, 1500).t_s, 0.004 + 50.0 * 1.0002, 1e-9);
  EXPECT_NEAR(exposure(free, Eye::kLeft, 1500).t_s, 50.0, 1e-12);
}

TEST(Exposures, GetLostAsOftenAsTheWorldSays) {
  const World lossy = world({.drop_probability = 0.1});
  const auto left = delivered(lossy, Eye::kLeft);
  const auto right = delivered(lossy, Eye::kRight);
  EXPECT_NEAR(static_cast<double>(left.size()), 1620.0, 50.0);
  EXPECT_NEAR(static_cast<double>(right.size()), 1620.0, 50.0);
  std::size_t both = 0;
  for (const Exposure& exposure : left)
    both += is_lost(lossy, Eye::kRight, exposure.number) ? 0U : 1U;
  EXPECT_NEAR(static_cast<double>(both), 0.81 * 1800, 60.0);  // each camera loses its own
}

TEST(Exposures, ComeInOrderWhateverTheJitter) {
  const World shaken = world({.jitter_s = 0.15 / 30.0, .right_offset_s = -0.01});
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    const auto all = delivered(shaken, eye);
    EXPECT_GE(all.front().t_s, 0.0);
    EXPECT_LT(all.back().t_s, shaken.duration_s);
    for (std::size_t i = 1; i < all.size(); ++i) EXPECT_GT(all[i].t_s, all[i - 1].t_s + 1e-6);
  }
}

TEST(Exposures, FollowFromTheSeed) {
  World a = world({.jitter_s = 0.001});
  World b = a;
  EXPECT_EQ(exposure(a, Eye::kLeft, 9).t_s, exposure(b, Eye::kLeft, 9).t_s);
  b.seed = 2;
  EXPECT_NE(exposure(a, Eye::kLeft, 9).t_s, exposure(b, Eye::kLeft, 9).t_s);
}

}  // namespace
}  // namespace egomod::sim
