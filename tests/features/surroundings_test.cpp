// SPDX-License-Identifier: Apache-2.0
#include "surroundings.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>

#include "synthetic_texture.hpp"

namespace egomod {
namespace {

constexpr int kManyPoints = 400;
constexpr float kWideImage_px = 700.0F;

TEST(SurroundingsTest, AreTheOthersWithinReachAndNoneElse) {
  const auto grey = testing::painted(64, 64, testing::WaveTexture(4));
  TrackStore store(kManyPoints);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(0.0F, kWideImage_px);
  for (int i = 0; i < kManyPoints; ++i)
    store.add(grey.view(), {32, 32}, CornerKind::kDark).left = {place(random), place(random)};
  Surroundings surroundings(kManyPoints);
  surroundings.sort(store);
  for (const FollowedPoint& point : store.points()) {
    std::multiset<std::uint64_t> found, wanted, found_near, wanted_near;
    surroundings.left.each_around(point.left, [&](const FollowedPoint& other, ImagePoint off) {
      EXPECT_EQ(off.u_px, other.left.u_px - point.left.u_px);
      EXPECT_EQ(off.v_px, other.left.v_px - point.left.v_px);
      found.insert(other.id);
    });
    surroundings.left.each_near(
        point.left, [&](const FollowedPoint& other, ImagePoint) { found_near.insert(other.id); });
    for (const FollowedPoint& other : store.points()) {
      const ImagePoint off = other.left - point.left;
      const float reach_px = std::max(std::abs(off.u_px), std::abs(off.v_px));
      if (reach_px <= PlaceGrid::kReach_px) wanted.insert(other.id);
      if (reach_px <= PlaceGrid::kNear_px) wanted_near.insert(other.id);
    }
    EXPECT_EQ(found, wanted);
    EXPECT_EQ(found_near, wanted_near);
  }
}

}  // namespace
}  // namespace egomod
