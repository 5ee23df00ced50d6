// SPDX-License-Identifier: Apache-2.0
// What moves fast against its surroundings must gain tracks, too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "egomod/features/feature_tracker.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod {
namespace {

using test_support::Body;
using test_support::Scene;
using test_support::SyntheticWorld;

constexpr int kWidth_px = 640;
constexpr double kDepth_m = 4.0;
constexpr double kInterval_s = 0.1;
constexpr int kPairs = 3;  // after the first
constexpr double kStep_px = 50.0;
constexpr double kEnd_m = 0.5;
constexpr double kMaxError_px = 3.0;
constexpr double kMinShareOfResting = 0.6;
constexpr double kMaxWrongShare = 0.1;

double speed_mps() {
  return kStep_px * kDepth_m / test_support::kinect_pair(kWidth_px).fx_px / kInterval_s;
}

// A poster on a board that ends at the same place, however fast it comes.
SyntheticWorld board_in_room(double speed_mps) {
  Scene scene = test_support::furnished_room();
  const auto front =
      test_support::add_texture(scene, 1.2, 0.8, 0.004, test_support::poster(1.2, 0.8, 77));
  Body board;
  board.id = 1;
  test_support::add_box(board, {{0, 0, 0}, {1.2, 0.8, 0.1}}, front, front);
  const double start_m = kEnd_m - speed_mps * kInterval_s * kPairs;
  board.T_world_body = test_support::steady(
      {.start_m = {start_m, 0, kDepth_m + 0.05}, .velocity_mps = {speed_mps, 0, 0}});
  scene.bodies.push_back(board);
  return {scene, test_support::kinect_pair(kWidth_px), {.noise_sigma = 1.5, .seed = 1}};
}

struct Carried {
  int right = 0;
  int wrong = 0;
};

// Tracks on the board after all pairs, by whether they moved as it did.
Carried carried_by(const SyntheticWorld& world, double step_px) {
  FeatureTracker tracker{FeaturesConfig{}};
  TrackSet tracks;
  for (int i = 0; i <= kPairs; ++i) {
    StereoPair pair;
    pair.sequence = static_cast<std::uint64_t>(i);
    pair.exposure = Nanoseconds(std::llround(i * kInterval_s * 1e9));
    pair.right_exposure = pair.exposure;
    pair.calibration.camera = world.camera();
    world.render(i * kInterval_s, pair.left, pair.right);
    tracker.track(pair, tracks);
  }
  const auto bodies = world.pixels(kPairs * kInterval_s).body_id;
  Carried carried;
  for (const Track& t : tracks.tracks) {
    const auto u = std::lround(t.current.u_px);
    const auto v = std::lround(t.current.v_px);
    if (!t.has_current || !t.has_previous) continue;
    if (bodies[static_cast<std::size_t>(v * kWidth_px + u)] != 1) continue;
    const double error_px =
        std::hypot(static_cast<double>(t.current.u_px - t.previous.u_px) - step_px,
                   static_cast<double>(t.current.v_px - t.previous.v_px));
    ++(error_px < kMaxError_px ? carried.right : carried.wrong);
  }
  return carried;
}

TEST(MoverSearchTest, AFastBoardCarriesNearlyAsManyTracksAsARestingOne) {
  const Carried resting = carried_by(board_in_room(0.0), 0.0);
  const Carried fast = carried_by(board_in_room(speed_mps()), kStep_px);
  EXPECT_GT(resting.right, 30);
  EXPECT_GT(fast.right, kMinShareOfResting * resting.right);
  EXPECT_LT(fast.wrong, kMaxWrongShare * fast.right);
}

TEST(MoverSearchTest, ItWorksInBothDirections) {
  const Carried resting = carried_by(board_in_room(0.0), 0.0);
  const Carried fast = carried_by(board_in_room(-speed_mps()), -kStep_px);
  EXPECT_GT(fast.right, kMinShareOfResting * resting.right);
  EXPECT_LT(fast.wrong, kMaxWrongShare * fast.right);
}

}  // namespace
}  // namespace egomod
