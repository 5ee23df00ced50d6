// SPDX-License-Identifier: Apache-2.0
#include "stereo_alignment.hpp"

#include <gtest/gtest.h>

#include "synthetic_texture.hpp"

namespace egomod {
namespace {

using testing::painted;
using testing::WaveTexture;

constexpr int kWidth = 160;
constexpr int kHeight = 100;
constexpr float kDisparity_px = 20.3F;
constexpr float kMaxError_px = 0.1F;  // of a single texture: interpolation, 8-bit rounding
constexpr double kFlowU_px = 3.0;
constexpr double kFlowV_px = -2.0;

Image shifted(const WaveTexture& texture, double u_px, double v_px) {
  return painted(kWidth, kHeight, [&](int u, int v) { return texture(u + u_px, v + v_px); });
}

// A fronto-parallel wall that moves by a known flow at a constant disparity.
class StereoAlignmentTest : public ::testing::Test {
 protected:
  StereoAlignmentTest() {
    const double d = static_cast<double>(kDisparity_px);
    take(previous_, shifted(texture_, 0.0, 0.0), shifted(texture_, d, 0.0));
    take(current_, shifted(texture_, -kFlowU_px, -kFlowV_px),
         shifted(texture_, d - kFlowU_px, -kFlowV_px));
    point_.previous_left = {80.0F, 50.0F};
    point_.previous_warp = {.u_px = 80.0F, .v_px = 50.0F};
    point_.left = {80.0F + static_cast<float>(kFlowU_px), 50.0F + static_cast<float>(kFlowV_px)};
    point_.warp = {.u_px = point_.left.u_px, .v_px = point_.left.v_px};
    point_.previous_stereo = {.valid = true, .disparity_px = kDisparity_px};
    point_.stereo = point_.previous_stereo;
  }

  static void take(StereoImages& images, const Image& left, const Image& right) {
    StereoPair pair;
    copy_image(left.view(), pair.left);
    copy_image(right.view(), pair.right);
    images.take(pair);
  }

  WaveTexture texture_{4};
  StereoImages previous_;
  StereoImages current_;
  FollowedPoint point_;
};

TEST_F(StereoAlignmentTest, MeasuresDisparityFromANearStart) {
  const StereoMeasurement found =
      align_stereo(current_, point_.left, {.disparity_px = kDisparity_px + 0.8F});
  EXPECT_TRUE(found.valid);
  EXPECT_NEAR(found.disparity_px, kDisparity_px, kMaxError_px);
}

TEST_F(StereoAlignmentTest, PatchesThatDoNotAgreeAreNotValid) {
  EXPECT_FALSE(align_stereo(current_, point_.left, {.disparity_px = 45.0F}).valid);
  EXPECT_FALSE(align_stereo(current_, {3.0F, 3.0F}, {.disparity_px = 2.0F}).valid);
}

TEST_F(StereoAlignmentTest, RightMatchesAreConsistentAndCloseTheCircle) {
  EXPECT_TRUE(is_consistent(current_, point_.left, point_.stereo));
  EXPECT_TRUE(closes_circle(previous_, current_, point_));
}

TEST_F(StereoAlignmentTest, WrongMatchesAreFoundOut) {
  for (const float error_px : {-9.0F, -1.7F, 1.7F, 4.0F}) {
    FollowedPoint wrong = point_;
    wrong.stereo.disparity_px += error_px;
    EXPECT_FALSE(is_consistent(current_, wrong.left, wrong.stereo)) << error_px;
    EXPECT_FALSE(closes_circle(previous_, current_, wrong)) << error_px;
  }
}

// The right images displaced as a skew does it, between pixels along both axes.
TEST_F(StereoAlignmentTest, AShiftedRightImageGivesTheSameDisparityAndClosesTheCircle) {
  const double d = static_cast<double>(kDisparity_px);
  constexpr double kShiftU_px = -3.4, kBeforeU_px = 2.2;
  for (const double shift_v_px : {-1.2, -0.5, 0.3, 0.8}) {
    take(previous_, shifted(texture_, 0.0, 0.0), shifted(texture_, d - kBeforeU_px, shift_v_px));
    take(current_, shifted(texture_, -kFlowU_px, -kFlowV_px),
         shifted(texture_, d - kFlowU_px - kShiftU_px, -kFlowV_px - shift_v_px));
    const StereoMeasurement start{
        .disparity_px = kDisparity_px + 0.8F,
        .skew_shift = {static_cast<float>(kShiftU_px), static_cast<float>(shift_v_px)}};
    point_.stereo = align_stereo(current_, point_.left, start);
    EXPECT_TRUE(point_.stereo.valid) << shift_v_px;
    EXPECT_NEAR(point_.stereo.disparity_px, kDisparity_px, kMaxError_px) << shift_v_px;
    EXPECT_GT(point_.stereo.ncc, 0.98F) << shift_v_px;
    EXPECT_TRUE(is_consistent(current_, point_.left, point_.stereo)) << shift_v_px;
    point_.previous_stereo.skew_shift = {static_cast<float>(kBeforeU_px),
                                         -static_cast<float>(shift_v_px)};
    EXPECT_TRUE(closes_circle(previous_, current_, point_)) << shift_v_px;
    FollowedPoint wrong = point_;
    wrong.stereo.skew_shift = {};
    EXPECT_FALSE(closes_circle(previous_, current_, wrong)) << shift_v_px;
  }
}

TEST_F(StereoAlignmentTest, ALeftPointThatSlidDoesNotCloseTheCircle) {
  FollowedPoint slid = point_;
  slid.left.v_px += 2.0F;
  slid.warp.v_px += 2.0F;
  EXPECT_FALSE(closes_circle(previous_, current_, slid));
}

// What is a wall at 12 px looks like a nearer point at 40 px, which is lost and sought again.
TEST_F(StereoAlignmentTest, WhatHasLeftTheRightImageIsNowhereElse) {
  constexpr float kLookAlike_px = 12.0F, kOwn_px = 40.0F;
  take(current_, shifted(texture_, 0.0, 0.0),
       shifted(texture_, static_cast<double>(kLookAlike_px), 0.0));
  const auto finds = [&](float u_px) {
    TrackStore store(4);
    FollowedPoint& point = store.add(current_.left.level(0), {static_cast<int>(u_px), 50}, {});
    point.left = {u_px, 50.0F};
    point.followed = true;
    point.expected_disparity_px = kOwn_px;
    point.previous_stereo.disparity_px = kOwn_px;
    Skew skew;
    StereoAlignment alignment(4, {.max_disparity_px = 60});
    alignment.measure(previous_, current_, skew, store);
    return store.points().front().stereo.valid;
  };
  EXPECT_TRUE(finds(90.0F));
  EXPECT_FALSE(finds(45.0F));
}

}  // namespace
}  // namespace egomod
