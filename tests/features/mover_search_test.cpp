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
constexpr int kPairs = 2;  // after the first
constexpr double kEnd_m = 0.5;
constexpr double kMaxError_px = 3.0;
constexpr double kMinShareOfResting = 0.5;
constexpr double kMaxWrongShare = 0.1;

struct Steps {
  double interval_s;
  double step_px;
};
constexpr Steps kResting{0.1, 0.0};

// A poster on a board that ends at the same place, however fast it comes.
SyntheticWorld board_in_room(Steps steps) {
  Scene scene = test_support::furnished_room();
  const auto front =
      test_support::add_texture(scene, 1.2, 0.8, 0.004, test_support::poster(1.2, 0.8, 77));
  Body board;
  board.id = 1;
  test_support::add_box(board, {{0, 0, 0}, {1.2, 0.8, 0.1}}, front, front);
  const double step_m = steps.step_px * kDepth_m / test_support::kinect_pair(kWidth_px).fx_px;
  const double start_m = kEnd_m - step_m * kPairs;
  const double speed_mps = step_m / steps.interval_s;
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
Carried carried_by(Steps steps) {
  const SyntheticWorld world = board_in_room(steps);
  FeatureTracker tracker{FeaturesConfig{}};
  TrackSet tracks;
  for (int i = 0; i <= kPairs; ++i) {
    StereoPair pair;
    pair.sequence = static_cast<std::uint64_t>(i);
    pair.exposure = Nanoseconds(std::llround(i * steps.interval_s * 1e9));
    pair.right_exposure = pair.exposure;
    pair.calibration.camera = world.camera();
    world.render(i * steps.interval_s, pair.left, pair.right);
    tracker.track(pair, tracks);
  }
  const auto bodies = world.pixels(kPairs * steps.interval_s).body_id;
  Carried carried;
  for (const Track& t : tracks.tracks) {
    const auto u = std::lround(t.current.u_px);
    const auto v = std::lround(t.current.v_px);
    if (!t.has_current || !t.has_previous) continue;
    if (bodies[static_cast<std::size_t>(v * kWidth_px + u)] != 1) continue;
    const double error_px =
        std::hypot(static_cast<double>(t.current.u_px - t.previous.u_px) - steps.step_px,
                   static_cast<double>(t.current.v_px - t.previous.v_px));
    ++(error_px < kMaxError_px ? carried.right : carried.wrong);
  }
  return carried;
}

// Step and interval.
class FastBoard : public ::testing::TestWithParam<Steps> {};

TEST_P(FastBoard, CarriesHalfAsManyTracksAsARestingOne) {
  const Carried resting = carried_by(kResting);
  const Carried fast = carried_by(GetParam());
  EXPECT_GT(resting.right, 30);
  EXPECT_GT(fast.right, kMinShareOfResting * resting.right);
  EXPECT_LT(fast.wrong, kMaxWrongShare * fast.right);
}

INSTANTIATE_TEST_SUITE_P(MoverSearchTest, FastBoard,
                         ::testing::Values(Steps{0.1, 50.0}, Steps{0.1, -50.0}, Steps{1.0, 150.0},
                                           Steps{1.0, 128.0}, Steps{1.0, -150.0}));

}  // namespace
}  // namespace egomod
