// SPDX-License-Identifier: Apache-2.0
#include "capture/pairing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "capture/live_pairing.hpp"

namespace egomod {
namespace {

using namespace std::chrono_literals;

TEST(PairByExposure, GivesEachRightImageToTheNearestLeftOnly) {
  const std::vector<Nanoseconds> left{0ms, 33ms, 66ms};
  const std::vector<Nanoseconds> right{20ms, 70ms};
  const auto partners = pair_by_exposure(left, right, 40ms);
  EXPECT_FALSE(partners[0].accepted);  // 33 ms is nearer to 20 ms
  EXPECT_TRUE(partners[1].accepted);
  EXPECT_EQ(partners[1].nearest, 0U);
  EXPECT_TRUE(partners[2].accepted);
  EXPECT_EQ(partners[2].nearest, 1U);
}

TEST(PairByExposure, RejectsAllWithoutRightImages) {
  const std::vector<Nanoseconds> left{0ms, 33ms};
  for (const Partner& partner : pair_by_exposure(left, {}, 1s)) {
    EXPECT_FALSE(partner.accepted);
    EXPECT_FALSE(partner.nearest);
  }
}

TEST(SkewLimit, IsHalfTheMedianIntervalByDefault) {
  const std::vector<Nanoseconds> left{0ms, 40ms, 80ms, 500ms};
  EXPECT_EQ(skew_limit(0.0, left, left), 20ms);
  EXPECT_EQ(skew_limit(0.005, left, left), 5ms);
  EXPECT_EQ(skew_limit(0.0, {left.data(), 1}, {}), 50ms) << "nothing tells the interval";
}

TEST(LivePairing, DecidesOnWhatWaitsWhenNothingMoreComes) {
  LivePairing pairing(0.0);
  EXPECT_FALSE(pairing.add_left({0ms, 0}));
  EXPECT_FALSE(pairing.add_left({33ms, 1}));
  EXPECT_FALSE(pairing.add_right({-1ms, 2}));
  EXPECT_FALSE(pairing.decide()) << "a nearer right image may come";
  pairing.end();
  EXPECT_TRUE(pairing.decide()->is_accepted);
  EXPECT_FALSE(pairing.decide()->is_accepted);
  EXPECT_FALSE(pairing.decide());
}

TEST(LivePairing, TakesNoNextRightImageForTheFirstOneThatIsLate) {
  LivePairing pairing(0.0);
  EXPECT_FALSE(pairing.add_left({0ms, 0}));
  EXPECT_FALSE(pairing.add_right({33ms, 1}));
  EXPECT_FALSE(pairing.decide()) << "nothing tells yet how far apart images are";
  EXPECT_FALSE(pairing.add_left({33ms, 2}));
  EXPECT_FALSE(pairing.decide()->is_accepted);
  const auto second = pairing.decide();
  ASSERT_TRUE(second && second->is_accepted);
  EXPECT_EQ(second->right->slot, 1U);
}

// Of both cameras the second image is lost: what is known of the interval is twice the true one.
TEST(LivePairing, TakesNoImageOfTheNextFrameByAnIntervalThatIsTooLong) {
  LivePairing pairing(0.0);
  EXPECT_FALSE(pairing.add_left({0ms, 0}));
  EXPECT_FALSE(pairing.add_right({33ms, 1}));
  EXPECT_FALSE(pairing.add_left({67ms, 2}));
  EXPECT_FALSE(pairing.decide()->is_accepted);
}

// Every second left image and every fifth right one is lost: the left ones come 67 ms apart.
TEST(LivePairing, TakesNoImageOfTheFrameBeforeWhileManyAreLost) {
  LivePairing pairing(0.0);
  int accepted = 0;
  for (std::size_t k = 0; k < 20; ++k) {
    const Nanoseconds exposure = static_cast<int>(k) * 33ms;
    if (k % 2 == 0) {
      EXPECT_FALSE(pairing.add_left({exposure, 0}));
    }
    if (k % 5 != 4) {
      EXPECT_FALSE(pairing.add_right({exposure, 0}));
    }
    while (const auto decision = pairing.decide()) {
      if (!decision->is_accepted) continue;
      ++accepted;
      EXPECT_EQ(decision->right->exposure, decision->left.exposure);
    }
    while (pairing.take_stale()) {
    }
  }
  EXPECT_GE(accepted, 6) << "of 8";
}

// Accepted pairs of left images at these times, each with a right one 1 ms later.
int accepted_of(LivePairing& pairing, const std::vector<Nanoseconds>& times) {
  int accepted = 0;
  for (const Nanoseconds time : times) {
    static_cast<void>(pairing.add_left({time, 0}));
    static_cast<void>(pairing.add_right({time + 1ms, 0}));
    while (const auto decision = pairing.decide()) accepted += decision->is_accepted ? 1 : 0;
    while (pairing.take_stale()) {
    }
  }
  return accepted;
}

TEST(LivePairing, LosesNothingToImagesThatComeTwice) {
  LivePairing pairing(0.0);
  EXPECT_EQ(accepted_of(pairing, {0ms, 0ms, 33ms, 33ms, 66ms, 100ms, 100ms, 133ms}), 5);
}

TEST(LivePairing, LosesNothingToARightImageFromTheFuture) {
  LivePairing pairing(0.0);
  EXPECT_EQ(accepted_of(pairing, {0ms, 33ms}), 2);
  EXPECT_EQ(pairing.add_right({1h, 7}), 7U);
  EXPECT_EQ(accepted_of(pairing, {66ms, 100ms, 133ms}), 3);
}

TEST(LivePairing, LearnsARateThatFallsFrom30To1Hz) {
  LivePairing pairing(0.0);
  EXPECT_EQ(accepted_of(pairing, {0ms, 33ms, 66ms, 100ms, 133ms}), 5);
  static_cast<void>(accepted_of(pairing, {1133ms, 2133ms, 3133ms}));
  static_cast<void>(pairing.add_left({4133ms, 0}));
  static_cast<void>(pairing.add_right({4333ms, 0}));
  const auto decision = pairing.decide();
  ASSERT_TRUE(decision && decision->is_accepted) << "200 ms are within half a second";
  EXPECT_FALSE(decision->discontinuity);
}

TEST(LivePairing, PairsTheFirstImagesOfCamerasThatRunFreelyAtALowRate) {
  LivePairing pairing(0.0);
  EXPECT_FALSE(pairing.add_left({0ms, 0}));
  EXPECT_FALSE(pairing.add_right({80ms, 1}));
  EXPECT_FALSE(pairing.decide());
  EXPECT_FALSE(pairing.add_left({200ms, 2}));
  EXPECT_TRUE(pairing.decide()->is_accepted);
}

TEST(LivePairing, PairsTheFirstImagesAtOnceThatAreExposedTogether) {
  LivePairing pairing(0.0);
  EXPECT_FALSE(pairing.add_left({0ms, 0}));
  EXPECT_FALSE(pairing.add_right({1ms, 1}));
  EXPECT_TRUE(pairing.decide()->is_accepted);
}

std::vector<int> kept(double max_rate_hz, const std::vector<Nanoseconds>& times) {
  RateLimiter limiter(max_rate_hz);
  std::vector<int> indices;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!limiter.is_due(times[i])) continue;
    limiter.keep(times[i]);
    indices.push_back(static_cast<int>(i));
  }
  return indices;
}

TEST(RateLimiter, KeepsEverythingAtZeroAndAtHigherRatesThanTheData) {
  const std::vector<Nanoseconds> times{0ms, 33ms, 67ms, 100ms};
  EXPECT_EQ(kept(0.0, times), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(kept(60.0, times), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(kept(30.0, times), (std::vector<int>{0, 1, 2, 3}));
}

TEST(RateLimiter, TurnsJitterNeitherIntoFifthsNorSevenths) {
  std::vector<Nanoseconds> times;
  for (int i = 0; i < 120; ++i) {
    const double jitter_s = 0.005 * std::sin(2.4 * i);
    times.emplace_back(std::llround(1e9 * (i / 30.0 + jitter_s)));
  }
  const std::vector<int> indices = kept(5.0, times);
  ASSERT_EQ(indices.size(), 20U);
  for (std::size_t i = 0; i < indices.size(); ++i) EXPECT_EQ(indices[i], 6 * static_cast<int>(i));
}

TEST(RateLimiter, WaitsForTheNextGoodPairWhenADueOneIsLost) {
  RateLimiter limiter(1.0);
  ASSERT_TRUE(limiter.is_due(0ms));
  limiter.keep(0ms);
  EXPECT_FALSE(limiter.is_due(500ms));
  EXPECT_TRUE(limiter.is_due(1000ms));  // found damaged: not kept
  EXPECT_TRUE(limiter.is_due(1500ms));
}

TEST(RateLimiter, StartsAnewWhenTheClockStepsBack) {
  EXPECT_EQ(kept(1.0, {10s, 10500ms, 2s, 2500ms, 3s}), (std::vector<int>{0, 2, 4}));
}

}  // namespace
}  // namespace egomod
