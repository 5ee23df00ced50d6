// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/interval_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egomod {
namespace {

class IntervalWatchTest : public ::testing::Test {
 protected:
  bool is_late_after(double interval_s) {
    t_s_ += interval_s;
    return watch_.is_late(Nanoseconds(std::llround(t_s_ * 1e9)));
  }
  int late_of(int pairs, double interval_s) {
    int late = 0;
    for (int k = 0; k < pairs; ++k) late += is_late_after(interval_s) ? 1 : 0;
    return late;
  }

  IntervalWatch watch_;
  double t_s_ = 5.0;
};

TEST_F(IntervalWatchTest, NoticesMissingPairsOnce) {
  for (const int missing : {1, 2, 5, 10}) {
    EXPECT_EQ(late_of(10, 1.0 / 30.0), 0);
    EXPECT_TRUE(is_late_after((missing + 1) / 30.0)) << missing;
  }
  EXPECT_EQ(late_of(10, 1.0 / 30.0), 0);
}

TEST_F(IntervalWatchTest, ALowerRateIsLateOnceAHigherOneNever) {
  EXPECT_EQ(late_of(30, 1.0 / 30.0), 0);
  EXPECT_EQ(late_of(10, 0.1), 1);
  EXPECT_EQ(late_of(10, 1.0), 1);
  EXPECT_EQ(late_of(30, 1.0 / 30.0), 0);
}

TEST_F(IntervalWatchTest, JitterIsNotLate) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(0.88, 1.12);  // of exposures, 0.15 of an interval
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(is_late_after(jitter(random) / 30.0)) << k;
}

TEST_F(IntervalWatchTest, AClockThatStepsBackIsNotLate) {
  EXPECT_EQ(late_of(10, 0.1), 0);
  EXPECT_FALSE(is_late_after(-3.0));
  EXPECT_FALSE(is_late_after(0.1));
}

}  // namespace
}  // namespace egomod
