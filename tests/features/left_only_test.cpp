// SPDX-License-Identifier: Apache-2.0
// What moves on where the right camera does not see it is followed in the left image alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "egomod/features/feature_tracker.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod {
namespace {

using test_support::SyntheticWorld;

constexpr int kHalfWidth_px = 320;
constexpr double kBoardDepth_m = 4.0;
constexpr double kRate_hz = 30.0;
constexpr double kStep_px = -1.5;
constexpr int kPairsToBorder = 40;
constexpr double kWidth_m = 0.9;
constexpr double kMaxError_px = 0.3;
constexpr double kMaxAstrayShare = 0.05;

// A poster on a board that goes to the left until half of it is beside the right image.
SyntheticWorld board_that_leaves() {
  test_support::Scene scene = test_support::furnished_room();
  const auto front = test_support::add_texture(scene, kWidth_m, 0.9, 0.004,
                                               test_support::poster(kWidth_m, 0.9, 7));
  test_support::Body board;
  board.id = 1;
  test_support::add_box(board, {{0, 0, 0}, {kWidth_m, 0.9, 0.1}}, front, front);
  const StereoCamera camera = test_support::kinect_pair(kHalfWidth_px);
  const double per_px_m = kBoardDepth_m / camera.fx_px;
  const double end_m = (camera.fx_px * camera.baseline_m / kBoardDepth_m - camera.cx_px) * per_px_m;
  board.T_world_body = test_support::steady(
      {.start_m = {end_m - kStep_px * kPairsToBorder * per_px_m, 0, kBoardDepth_m + 0.05},
       .velocity_mps = {kStep_px * kRate_hz * per_px_m, 0, 0}});
  scene.bodies.push_back(board);
  return {scene, camera, {.noise_sigma = 1.5, .seed = 1}};
}

TEST(LeftOnly, WhatMovesIsFollowedBesideTheRightImageAndWhatRestsIsNot) {
  const SyntheticWorld world = board_that_leaves();
  FeatureTracker tracker{FeaturesConfig{}};
  TrackSet tracks;
  std::map<std::uint64_t, float> before_px;
  int alone = 0;  // in the last pair
  std::map<std::uint64_t, int> pairs_alone;
  int longest = 0;
  int followed = 0;
  int astray = 0;
  for (int i = 0; i <= kPairsToBorder; ++i) {
    StereoPair pair;
    pair.sequence = static_cast<std::uint64_t>(i);
    pair.exposure = pair.right_exposure = Nanoseconds(std::llround(i / kRate_hz * 1e9));
    pair.calibration.camera = world.camera();
    world.render(i / kRate_hz, pair.left, pair.right);
    tracker.track(pair, tracks);
    alone = 0;
    for (const Track& track : tracks.tracks) {
      const float u_px = track.current.u_px;
      if (track.left_only) {
        ++alone;
        EXPECT_FALSE(track.has_current);
        ++followed;
        longest = std::max(longest, ++pairs_alone[track.id]);
        astray += std::abs(u_px - before_px[track.id] - kStep_px) > kMaxError_px ? 1 : 0;
      }
      before_px[track.id] = u_px;
    }
  }
  EXPECT_GE(alone, 8);
  EXPECT_GE(longest, 15);
  EXPECT_LT(astray, kMaxAstrayShare * followed);
}

}  // namespace
}  // namespace egomod
