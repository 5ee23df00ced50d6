// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/latency_histogram.hpp"

#include <gtest/gtest.h>

namespace egomod {
namespace {

constexpr double kBucketShare = 1.0 / 32.0;  // half a bucket

TEST(LatencyHistogram, is_all_zero_when_empty) {
  const LatencySummary summary = LatencyHistogram().summary();
  EXPECT_EQ(summary.count, 0U);
  EXPECT_EQ(summary.p99.count(), 0);
  EXPECT_EQ(summary.max.count(), 0);
}

TEST(LatencyHistogram, gives_quantiles_within_half_a_bucket_and_the_exact_maximum) {
  LatencyHistogram histogram;
  for (int us = 1; us <= 1000; ++us) {
    histogram.add(std::chrono::microseconds(us));
  }
  const LatencySummary summary = histogram.summary();
  EXPECT_EQ(summary.count, 1000U);
  EXPECT_NEAR(static_cast<double>(summary.p50.count()), 500e3, 500e3 * kBucketShare);
  EXPECT_NEAR(static_cast<double>(summary.p99.count()), 990e3, 990e3 * kBucketShare);
  EXPECT_EQ(summary.max, std::chrono::milliseconds(1));
}

TEST(LatencyHistogram, finds_each_single_duration_again) {
  for (std::int64_t ns = 1; ns < std::int64_t{1} << 38; ns = ns * 3 + 1) {
    LatencyHistogram histogram;
    histogram.add(Nanoseconds(ns));
    histogram.add(std::chrono::hours(1));  // so that the maximum does not cap the median
    EXPECT_NEAR(static_cast<double>(histogram.summary().p50.count()), static_cast<double>(ns),
                static_cast<double>(ns) * kBucketShare);
  }
}

TEST(LatencyHistogram, takes_a_clock_that_ran_backwards_as_zero) {
  LatencyHistogram histogram;
  histogram.add(Nanoseconds(-5));
  EXPECT_EQ(histogram.summary().max.count(), 0);
  EXPECT_EQ(histogram.summary().count, 1U);
}

}  // namespace
}  // namespace egomod
