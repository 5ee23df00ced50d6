// SPDX-License-Identifier: Apache-2.0
#include "rig_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "egomod/core/geometry.hpp"
#include "synthetic_texture.hpp"
#include "temporal_alignment.hpp"
#include "test_camera.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

constexpr int kPoints = 200;
constexpr float kMaxError_px = 0.2F;

Eigen::Isometry3d ahead_and_left() {
  Vector6d xi;
  xi << 0.02, 0.0, -0.4, 0.0, 0.05, 0.01;
  return se3_exp(xi);
}

ImagePoint seen(const Eigen::Vector3d& P_m) {
  const Eigen::Vector3d uvd = project(kCamera, P_m);
  return {static_cast<float>(uvd.x()), static_cast<float>(uvd.y())};
}

// Points between 2 and 20 m; the share that moves goes 0.5 m to the right.
void fill(TrackStore& store, double moving_share) {
  const Image image = testing::flat_image(64, 64, 120.0, 10.0, 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> across(-0.4, 0.4), depth_m(2.0, 20.0);
  for (int i = 0; i < kPoints; ++i) {
    const double z = depth_m(random);
    const Eigen::Vector3d P(across(random) * z, across(random) * z, z);
    FollowedPoint& point = store.add(image.view(), {32, 32}, CornerKind::kDark);
    const Eigen::Vector3d own(i < moving_share * kPoints ? 0.5 : 0.0, 0.0, 0.0);
    point.previous_left = seen(P);
    point.previous_stereo.disparity_px = static_cast<float>(project(kCamera, P).z());
    point.left = seen(ahead_and_left() * (P + own));
    point.followed = true;
  }
}

TEST(RigMotionTest, PredictsRestingPointsAmongMovers) {
  TrackStore store(kPoints);
  fill(store, 0.3);
  RigMotion motion;
  motion.begin_pair(kCamera, true, 1.0F);
  ASSERT_TRUE(motion.guess(store));
  for (std::size_t i = kPoints / 2; i < kPoints; ++i) {
    const FollowedPoint& point = store.points()[i];
    const auto expected = motion.predict(point);
    ASSERT_TRUE(expected.has_value());
    EXPECT_NEAR(expected->left.u_px, point.left.u_px, kMaxError_px);
    EXPECT_NEAR(expected->left.v_px, point.left.v_px, kMaxError_px);
    const double z_m = kCamera.fx_px * kCamera.baseline_m /
                       static_cast<double>(point.previous_stereo.disparity_px);
    EXPECT_GT(expected->disparity_px, point.previous_stereo.disparity_px) << z_m << " m";
  }
}

// What noise makes of rest must not become part of where all tracks are looked for.
TEST(RigMotionTest, ARestingRigIsExpectedToStandQuiteStill) {
  TrackStore store(kPoints);
  fill(store, 0.0);
  std::mt19937 random(3);
  std::normal_distribution<float> noise_px(0.0F, 0.05F);
  for (FollowedPoint& point : store.points()) {
    point.left = {point.previous_left.u_px + noise_px(random),
                  point.previous_left.v_px + noise_px(random)};
  }
  RigMotion motion;
  motion.begin_pair(kCamera, true, 1.0F);
  ASSERT_TRUE(motion.guess(store));
  const FollowedPoint& point = store.points().back();
  const auto expected = motion.predict(point);
  ASSERT_TRUE(expected.has_value());
  EXPECT_FLOAT_EQ(expected->left.u_px, point.previous_left.u_px);
  EXPECT_FLOAT_EQ(expected->left.v_px, point.previous_left.v_px);
}

TEST(RigMotionTest, SaysNothingWherePointsDisagree) {
  TrackStore store(kPoints);
  fill(store, 0.0);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> anywhere(0.0F, 480.0F);
  for (FollowedPoint& point : store.points()) point.left = {anywhere(random), anywhere(random)};
  RigMotion motion;
  motion.begin_pair(kCamera, true, 1.0F);
  EXPECT_FALSE(motion.guess(store));
  EXPECT_FALSE(motion.predict(store.points().front()).has_value());
}

TEST(RigMotionTest, SaysNothingOfFewPointsOrWithoutACamera) {
  TrackStore store(kPoints);
  fill(store, 0.0);
  RigMotion motion;
  motion.begin_pair(StereoCamera{}, true, 1.0F);
  EXPECT_FALSE(motion.guess(store));
  motion.begin_pair(kCamera, true, 1.0F);
  for (std::size_t i = 5; i < kPoints; ++i) store.points()[i].followed = false;
  EXPECT_FALSE(motion.guess(store));
}

TEST(RigMotionTest, PredictsNothingWithoutADisparity) {
  TrackStore store(kPoints);
  fill(store, 0.0);
  RigMotion motion;
  motion.begin_pair(kCamera, true, 1.0F);
  ASSERT_TRUE(motion.guess(store));
  store.points().front().previous_stereo.disparity_px = 0.0F;
  EXPECT_FALSE(motion.predict(store.points().front()).has_value());
}

// Bars that repeat, each a little different: a period off, a point fits less well than at rest.
TEST(RigMotionTest, WhatRestedSoFarGoesBackFromALookAlike) {
  constexpr float kPeriod_px = 12.0F;
  constexpr ImagePoint kRest{100.0F, 50.0F};
  const testing::WaveTexture own(4);
  StereoPair pair;
  pair.left = testing::painted(200, 100, [&](int u, int v) {
    const double bars = std::sin(2.0 * M_PI * u / static_cast<double>(kPeriod_px)) *
                        std::sin(2.0 * M_PI * v / static_cast<double>(kPeriod_px));
    return 0.7 * (120.0 + 60.0 * bars) + 0.3 * own(u, v);
  });
  copy_image(pair.left.view(), pair.right);
  StereoImages images;
  images.take(pair);
  TemporalAlignment alignment(kPoints + 1);
  for (const float elsewhere_ncc : {0.9F, 0.99F}) {
    TrackStore store(kPoints + 1);
    for (int i = 0; i < kPoints; ++i) {
      FollowedPoint& point = store.add(images.left.level(0), {20 + i % 150, 50}, {});
      point.left = point.previous_left = {20.0F + static_cast<float>(i % 150), 50.0F};
      point.previous_stereo.disparity_px = 20.0F;
      point.followed = true;
    }
    RigMotion motion;
    motion.begin_pair(kCamera, true, 1.0F);
    ASSERT_TRUE(motion.guess(store));
    FollowedPoint& point = store.add(images.left.level(0), nearest_pixel(kRest), {});
    point.age = 20;
    point.previous_warp = point.warp;
    point.previous_left = kRest;
    point.previous_stereo.disparity_px = 20.0F;
    point.left = kRest + ImagePoint{kPeriod_px, 0.0F};
    point.followed = true;
    point.ncc = elsewhere_ncc;
    alignment.follow_rig(motion, images, store);
    EXPECT_NEAR(point.left.u_px, kRest.u_px + (elsewhere_ncc > 0.98F ? kPeriod_px : 0.0F), 0.1F);
  }
}

}  // namespace
}  // namespace egomod
