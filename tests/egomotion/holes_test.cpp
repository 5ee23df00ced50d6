// SPDX-License-Identifier: Apache-2.0
// Pairs that are missing, and rates that change: what was seen before and after is what counts.
#include <gtest/gtest.h>

#include "rendered_drive.hpp"

namespace egomod {
namespace {

using test_support::RenderedDrive;

constexpr double kPairInterval_s = 1.0 / 30.0;
constexpr double kMaxBridged_m = 0.005;          // of a motion over up to a third of a second
constexpr double kMaxErrorOverASecond_m = 0.02;  // 0.5 m and a turn
constexpr double kReset_m2 = 0.5;

class HolesTest : public ::testing::Test {
 protected:
  void see_some(int pairs, double interval_s) {
    for (int k = 0; k < pairs; ++k) {
      t_s_ += interval_s;
      drive_.see(t_s_);
      EXPECT_EQ(drive_.motion().status, EstimateStatus::kValid) << t_s_;
    }
  }
  // The first estimate after a hole is composed over it, or says that it starts anew.
  void expect_bridged_or_reseeded(double max_error_m) const {
    const Egomotion& motion = drive_.motion();
    if (motion.status == EstimateStatus::kValid) {
      EXPECT_EQ(motion.reason, EstimateReason::kHole);
      EXPECT_LT(drive_.step_error_m(), max_error_m);
      return;
    }
    EXPECT_EQ(motion.status, EstimateStatus::kFirst);
    EXPECT_EQ(motion.reason, EstimateReason::kReseeded);
    EXPECT_EQ(drive_.step_m(), 0.0);
    EXPECT_GT(motion.covariance_first_current(0, 0), kReset_m2);
  }

  RenderedDrive drive_;
  double t_s_ = 0.0;
};

TEST_F(HolesTest, one_two_five_and_ten_missing_pairs_are_bridged_by_tracks) {
  drive_.see(t_s_);
  see_some(10, kPairInterval_s);
  for (const int missing : {1, 2, 5, 10}) {
    t_s_ += (missing + 1) * kPairInterval_s;
    drive_.see(t_s_);
    EXPECT_EQ(drive_.motion().status, EstimateStatus::kValid) << missing;
    EXPECT_EQ(drive_.motion().reason, EstimateReason::kHole) << missing;
    EXPECT_LT(drive_.step_error_m(), kMaxBridged_m) << missing;
    see_some(5, kPairInterval_s);
    EXPECT_EQ(drive_.motion().reason, EstimateReason::kNone) << missing;
  }
  EXPECT_EQ(drive_.motion().reset_count, 0U);
}

// As live, where pairs that there was no time for leave a gap in the numbers.
TEST_F(HolesTest, dropped_pairs_are_bridged_by_tracks) {
  drive_.see(t_s_);
  see_some(5, kPairInterval_s);
  drive_.skip_numbers(5);
  t_s_ += 6 * kPairInterval_s;
  drive_.see(t_s_);
  EXPECT_EQ(drive_.motion().reason, EstimateReason::kHole);
  EXPECT_LT(drive_.step_error_m(), kMaxBridged_m);
}

TEST_F(HolesTest, a_rate_that_falls_from_30_to_10_to_1_hz_is_followed) {
  drive_.see(t_s_);
  see_some(10, kPairInterval_s);
  for (const double interval_s : {0.1, 1.0}) {
    for (int k = 0; k < 4; ++k) {
      t_s_ += interval_s;
      drive_.see(t_s_);
      if (k == 0) expect_bridged_or_reseeded(kMaxErrorOverASecond_m);
      if (k == 0 || drive_.motion().status != EstimateStatus::kValid) continue;
      EXPECT_EQ(drive_.motion().reason, EstimateReason::kNone) << interval_s;
      EXPECT_LT(drive_.step_error_m(), kMaxErrorOverASecond_m) << interval_s;
    }
    EXPECT_EQ(drive_.motion().status, EstimateStatus::kValid) << interval_s;
  }
  see_some(5, kPairInterval_s);
}

TEST_F(HolesTest, what_no_track_bridges_starts_anew_where_it_was) {
  drive_.see(t_s_);
  see_some(5, kPairInterval_s);
  // Behind the hole the rig looks elsewhere: both images are turned upside down.
  const auto upside_down = [](StereoPair& pair) {
    for (Image* image : {&pair.left, &pair.right})
      for (int v = 0; v < image->height_px() / 2; ++v)
        std::swap_ranges(image->row(v), image->row(v) + image->width_px(),
                         image->row(image->height_px() - 1 - v));
  };
  t_s_ += 0.3;
  bool reseeded = false;
  for (int k = 0; k < 3; ++k) {
    drive_.see(t_s_, upside_down);
    EXPECT_TRUE(drive_.motion().status != EstimateStatus::kValid || reseeded) << k;
    EXPECT_LT(drive_.step_m(), reseeded ? 1.0 : 1e-9) << k;
    reseeded = reseeded || drive_.motion().reason == EstimateReason::kReseeded;
    t_s_ += kPairInterval_s;
  }
  EXPECT_TRUE(reseeded);
  EXPECT_EQ(drive_.motion().reset_count, 1U);
  EXPECT_GT(drive_.motion().covariance_first_current(0, 0), kReset_m2);
}

}  // namespace
}  // namespace egomod
