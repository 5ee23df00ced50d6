// SPDX-License-Identifier: Apache-2.0
// Images that show nothing, or nothing sharp: said within one pair, over within two.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "rendered_drive.hpp"

namespace egomod {
namespace {

using test_support::RenderedDrive;

constexpr double kInterval_s = 1.0 / 30.0;
constexpr int kGoodPairs = 8;
constexpr int kBlindPairs = 6;
constexpr double kMaxError_m = 0.005;
constexpr double kNoise = 1.5;  // grey levels

// Both images become what `grey(u, v)` is, with noise.
template <typename Grey>
RenderedDrive::Spoil paint(const Grey& grey) {
  return [grey](StereoPair& pair) {
    std::mt19937 random(static_cast<std::uint32_t>(pair.sequence));
    std::normal_distribution<double> noise(0.0, kNoise);
    for (Image* image : {&pair.left, &pair.right})
      for (int v = 0; v < image->height_px(); ++v)
        for (int u = 0; u < image->width_px(); ++u)
          image->row(v)[u] = static_cast<std::uint8_t>(
              std::clamp(std::lround(grey(*image, u, v) + noise(random)), 0L, 255L));
  };
}

RenderedDrive::Spoil covered_lenses() {
  return paint([](const Image&, int, int) { return 4.0; });
}
// Light from one side.
RenderedDrive::Spoil white_wall() {
  return paint([](const Image&, int u, int v) { return 215.0 + 0.05 * u - 0.02 * v; });
}
// A candle's share of the light: what there was drowns in the noise.
RenderedDrive::Spoil darkness() {
  return paint([](const Image& image, int u, int v) { return 3.0 + 0.005 * image.row(v)[u]; });
}

// The mean over `length_px` along the row, as of a rig that turns while the shutter is open.
void smear(Image& image, int length_px) {
  const int width = image.width_px();
  std::vector<std::uint8_t> row(static_cast<std::size_t>(width));
  for (int v = 0; v < image.height_px(); ++v) {
    std::copy_n(image.row(v), width, row.begin());
    for (int u = 0; u < width; ++u) {
      int sum = 0;
      for (int k = 0; k < length_px; ++k)
        sum += row[static_cast<std::size_t>(std::clamp(u + k - length_px / 2, 0, width - 1))];
      image.row(v)[u] = static_cast<std::uint8_t>(sum / length_px);
    }
  }
}
RenderedDrive::Spoil motion_blur(int length_px) {
  return [length_px](StereoPair& pair) {
    smear(pair.left, length_px);
    smear(pair.right, length_px);
  };
}

void cover_right(StereoPair& pair) {
  Image left;
  copy_image(pair.left.view(), left);
  covered_lenses()(pair);
  copy_image(left.view(), pair.left);
}

struct Fault {
  const char* name;
  RenderedDrive::Spoil spoil;
  bool blinds;  // else something may still be seen, and what is said of it must be true
};

class BlindPairsTest : public ::testing::TestWithParam<Fault> {
 protected:
  void see(const RenderedDrive::Spoil& spoil = {}) {
    drive_.see(kInterval_s * pair_++, spoil);
    const Egomotion& motion = drive_.motion();
    EXPECT_TRUE(motion.T_first_current.matrix().allFinite()) << pair_;
    EXPECT_TRUE(motion.covariance_first_current.allFinite()) << pair_;
    EXPECT_TRUE(motion.covariance_previous_current.allFinite()) << pair_;
    if (motion.status == EstimateStatus::kValid) {
      // Over blind pairs the pose takes up what the map of tracks remembers.
      if (!was_blind_) {
        EXPECT_LT(drive_.step_error_m(), kMaxError_m) << pair_;
      }
    } else {
      EXPECT_EQ(drive_.step_m(), 0.0) << pair_;
      EXPECT_TRUE(motion.status == EstimateStatus::kFirst || motion.reason != EstimateReason::kNone)
          << pair_;
    }
    was_blind_ = motion.status != EstimateStatus::kValid;
  }

  RenderedDrive drive_;
  int pair_ = 0;
  bool was_blind_ = true;
};

TEST_P(BlindPairsTest, are_told_at_once_and_over_within_two_pairs) {
  for (int k = 0; k < kGoodPairs; ++k) see();
  ASSERT_EQ(drive_.motion().status, EstimateStatus::kValid);
  for (int k = 0; k < kBlindPairs; ++k) {
    see(GetParam().spoil);
    if (!GetParam().blinds) continue;
    EXPECT_EQ(drive_.motion().status, EstimateStatus::kFailed) << k;
    EXPECT_NE(drive_.motion().reason, EstimateReason::kNone) << k;
    EXPECT_EQ(drive_.motion().quality, 0) << k;
  }
  int invalid = 0;
  for (int k = 0; k < kGoodPairs; ++k) {
    see();
    if (drive_.motion().status != EstimateStatus::kValid) invalid = k + 1;
  }
  EXPECT_LE(invalid, 2);
  // What shows through the blur may be tracked for itself: one cut more.
  EXPECT_LE(drive_.motion().reset_count, GetParam().blinds ? 1U : 2U);
  if (drive_.motion().reset_count > 0) {
    EXPECT_GT(drive_.motion().covariance_first_current(0, 0), 0.5);
  }
}

TEST_P(BlindPairsTest, one_alone_is_bridged) {
  for (int k = 0; k < kGoodPairs; ++k) see();
  see(GetParam().spoil);
  see();
  see();
  EXPECT_EQ(drive_.motion().status, EstimateStatus::kValid);
  see();
  EXPECT_LT(drive_.step_error_m(), kMaxError_m);
}

INSTANTIATE_TEST_SUITE_P(Faults, BlindPairsTest,
                         ::testing::Values(Fault{"covered_lenses", covered_lenses(), true},
                                           Fault{"covered_right_lens", cover_right, true},
                                           Fault{"white_wall", white_wall(), true},
                                           Fault{"darkness", darkness(), true},
                                           Fault{"some_blur", motion_blur(5), false},
                                           Fault{"much_blur", motion_blur(41), false}),
                         [](const auto& fault) { return fault.param.name; });

}  // namespace
}  // namespace egomod
