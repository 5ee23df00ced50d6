// SPDX-License-Identifier: Apache-2.0
#include "seeding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "synthetic_texture.hpp"

namespace egomod {
namespace {

using testing::painted;

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 240;
constexpr int kDisparity_px = 20;
constexpr int kCapacity = 100;
constexpr int kTile_px = 9;
constexpr int kFaint_px = 230;  // from here on to the right
constexpr std::size_t kMovers = 3;

// Tiles at one depth, strong ones on the left and faint ones on the right.
double tile(int u, int v) {
  const auto column = static_cast<std::uint32_t>(u / kTile_px);
  const auto row = static_cast<std::uint32_t>(v / kTile_px);
  const std::uint32_t hash = (column * 73856093U ^ row * 19349663U) * 2654435761U;
  return 128.0 + (u < kFaint_px ? 60.0 : 15.0) * ((hash >> 24 & 255U) / 127.5 - 1.0);
}

StereoImages tiles() {
  StereoPair pair;
  pair.left = painted(kWidth_px, kHeight_px, [](int u, int v) { return tile(u, v); });
  pair.right =
      painted(kWidth_px, kHeight_px, [](int u, int v) { return tile(u + kDisparity_px, v); });
  StereoImages images;
  images.take(pair);
  return images;
}

struct Motion {
  int pairs;
  float share;  // of the flow, by themselves
};

// New tracks where three faint ones have moved so, while the strong ones take nearly all places.
std::ptrdiff_t gained_around(Motion motion) {
  const StereoImages images = tiles();
  const Skew skew;
  TrackStore store(kCapacity);
  Seeding seeding(kCapacity, {.bucket_px = 26, .corners_per_bucket = 3}, {});
  seeding.seed(images, skew, store);
  EXPECT_TRUE(store.full());
  store.drop_if([](const FollowedPoint& p) { return p.left.u_px >= kFaint_px || p.id % 5 == 0; });
  for (std::size_t k = 0; k < kMovers; ++k) {
    const PixelPosition place{kFaint_px + 40, 100 + 12 * static_cast<int>(k)};
    FollowedPoint& mover = store.add(images.left.level(0), place, CornerKind::kDark);
    mover.age = 10;
    mover.stereo = {.valid = true, .disparity_px = kDisparity_px};
    mover.pairs_moving = motion.pairs;
    mover.flow = {10.0F, 0.0F};
    mover.own_motion = {10.0F * motion.share, 0.0F};
  }
  for (int call = 0; call < CornerDetector::kPatience; ++call) {
    seeding.seed(images, skew, store);
    store.drop_if([&](const FollowedPoint& p) { return call == 0 && p.id % 7 == 0; });
  }
  const auto on_faint =
      std::count_if(store.points().begin(), store.points().end(),
                    [](const FollowedPoint& p) { return p.left.u_px >= kFaint_px; });
  return on_faint - static_cast<std::ptrdiff_t>(kMovers);
}

TEST(SeedingTest, WhatShowsFewMovingTracksGainsSomeBeforeWhatIsStronger) {
  EXPECT_GE(gained_around({.pairs = 3, .share = 0.5F}), 6);
  EXPECT_LE(gained_around({.pairs = 2, .share = 0.5F}), 1) << "a mistake, perhaps";
  EXPECT_LE(gained_around({.pairs = 3, .share = 0.05F}), 1) << "no more than the flow may err by";
}

}  // namespace
}  // namespace egomod
