// SPDX-License-Identifier: Apache-2.0
#include "surface_check.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stereo_alignment.hpp"
#include "synthetic_texture.hpp"

namespace egomod {
namespace {

constexpr int kViewWidth = 220;
constexpr int kViewHeight = 100;
constexpr float kFloorSlope = 0.7F;  // disparity gained from row to row
constexpr float kFloorError_px = 0.3F;
constexpr PixelPosition kPlace{150, 50};

float floor_disparity_px(float v_px) { return 25.0F + kFloorSlope * (v_px - 50.0F); }

template <class Grey, class Disparity>
StereoImages view(Grey grey, Disparity disparity_px) {
  StereoPair pair;
  pair.left = testing::painted(kViewWidth, kViewHeight, grey);
  pair.right = testing::painted(kViewWidth, kViewHeight, [&](int u, int v) {
    return grey(u + static_cast<double>(disparity_px(static_cast<float>(v))), v);
  });
  StereoImages images;
  images.take(pair);
  return images;
}

Surroundings surroundings_of(const TrackStore& store) {
  Surroundings surroundings(8);
  surroundings.sort(store);
  return surroundings;
}

// A point with a match of its own, among neighbours that lie on a plane.
struct Scene {
  Scene(const StereoImages& images, StereoMeasurement own, StereoMeasurement neighbours) {
    const ImageView left = images.left.level(0);
    own.valid = neighbours.valid = true;
    const float at_place_px = neighbours.disparity_px;
    for (const int off_px : {-14, 12}) {
      neighbours.disparity_px =
          at_place_px + static_cast<float>(off_px) * (neighbours.slope_u + neighbours.slope_v);
      store.add(left, {kPlace.u_px + off_px, kPlace.v_px + off_px}, CornerKind::kDark).stereo =
          neighbours;
    }
    store.add(left, kPlace, CornerKind::kDark).stereo = own;
  }
  [[nodiscard]] StereoMeasurement settled(const StereoImages& images) const {
    return settle_by_neighbours(images, Skew(), surroundings_of(store), store.points().back());
  }
  TrackStore store{8};
};

TEST(SurfaceCheckTest, AFloorThatGoesOnBeatsALookAlike) {
  const StereoImages images = view(testing::WaveTexture(4), floor_disparity_px);
  const Scene scene(images, {.disparity_px = 60.0F, .ncc = 0.88F},
                    {.disparity_px = 25.0F, .slope_v = kFloorSlope, .ncc = 0.95F});
  const StereoMeasurement settled = scene.settled(images);
  EXPECT_TRUE(settled.valid);
  EXPECT_NEAR(settled.disparity_px, 25.0F, kFloorError_px);
}

TEST(SurfaceCheckTest, WhatStandsBeforeItsNeighboursStays) {
  const StereoImages images = view(testing::WaveTexture(4), [](float) { return 60.0F; });
  const Scene scene(images, {.disparity_px = 60.0F, .ncc = 0.97F},
                    {.disparity_px = 25.0F, .slope_v = kFloorSlope, .ncc = 0.95F});
  const StereoMeasurement settled = scene.settled(images);
  EXPECT_TRUE(settled.valid);
  EXPECT_EQ(settled.disparity_px, 60.0F);
}

// A wall that both cameras see, and a point of the left image whose match lies on it: what is seen
// there has its place on the wall already.
TEST(SurfaceCheckTest, WhatTheRightImageShowsBelongsToOnePlaceOnly) {
  constexpr float kWall_px = 30.0F;
  constexpr float kOff_px = 25.0F;  // that the hidden point claims to be nearer
  const testing::WaveTexture wall(4), strange(5);
  const auto hidden = [](double u) { return std::abs(u - kPlace.u_px) < 9.0; };
  const auto look_alike = [&](double u, double v) {
    return hidden(u) ? 0.93 * wall(u - static_cast<double>(kOff_px), v) + 0.07 * strange(u, v)
                     : wall(u, v);
  };
  StereoPair pair;
  pair.left = testing::painted(kViewWidth, kViewHeight, look_alike);
  pair.right = testing::painted(kViewWidth, kViewHeight, [&](int u, int v) {
    return wall(u + static_cast<double>(kWall_px), v);
  });
  StereoImages images;
  images.take(pair);
  const StereoMeasurement on_wall{.disparity_px = kWall_px, .ncc = 0.99F};
  const Scene wrong(images, {.disparity_px = kWall_px + kOff_px, .ncc = 0.97F}, on_wall);
  EXPECT_TRUE(
      belongs_to_another(images, surroundings_of(wrong.store), wrong.store.points().back()));
  EXPECT_FALSE(wrong.settled(images).valid);
  const Scene right(images, on_wall, on_wall);
  EXPECT_FALSE(
      belongs_to_another(images, surroundings_of(right.store), right.store.points().back()));
}

// Near the left border the right camera does not see what is near.
TEST(SurfaceCheckTest, WhatLiesOutsideOfTheRightImageHasNoMatch) {
  constexpr PixelPosition kBorder{60, 50};
  constexpr StereoMeasurement kFar{.disparity_px = 20.0F, .ncc = 0.97F};
  const StereoImages images = view(testing::WaveTexture(4), [](float) { return 20.0F; });
  TrackStore store(8);
  const auto add = [&](int off_px, StereoMeasurement stereo) -> FollowedPoint& {
    FollowedPoint& point = store.add(
        images.left.level(0), {kBorder.u_px + off_px, kBorder.v_px + off_px}, CornerKind::kDark);
    stereo.valid = true;
    point.stereo = stereo;
    return point;
  };
  add(0, kFar);
  for (const int off_px : {10, 20, 30}) add(off_px, {.disparity_px = 70.0F, .ncc = 0.95F});
  const auto settles = [&] {
    return settle_by_neighbours(images, Skew(), surroundings_of(store), store.points().front())
        .valid;
  };
  EXPECT_FALSE(settles());
  FollowedPoint& far = add(-15, kFar);  // a new one may be as wrong
  EXPECT_FALSE(settles());
  far.age = 10;  // so there is something far
  EXPECT_TRUE(settles());
  far.own_motion = {0.0F, 1.0F};
  EXPECT_FALSE(settles());
}

// Left of something nearer in the left image, right of it in the right one.
TEST(SurfaceCheckTest, WhatIsSeenPastSomethingNearerMustBeBorneOut) {
  constexpr StereoMeasurement kFar{.valid = true, .disparity_px = 20.0F, .ncc = 0.97F};
  constexpr StereoMeasurement kNear{.valid = true, .disparity_px = 60.0F, .ncc = 0.97F};
  const StereoImages images = view(testing::WaveTexture(4), [](float) { return 20.0F; });
  TrackStore store(8);
  const auto add = [&](int off_px, const StereoMeasurement& stereo, std::uint32_t age) {
    FollowedPoint& point =
        store.add(images.left.level(0), {kPlace.u_px + off_px, kPlace.v_px}, CornerKind::kDark);
    point.stereo = stereo;
    point.age = age;
  };
  const auto settles = [&] {
    return settle_by_neighbours(images, Skew(), surroundings_of(store), store.points().front())
        .valid;
  };
  add(0, kFar, 0);
  add(10, kNear, 0);  // may be wrong itself
  EXPECT_TRUE(settles());
  add(15, kNear, 10);
  EXPECT_FALSE(settles());
  add(-15, kFar, 10);
  EXPECT_TRUE(settles());
}

TEST(SurfaceCheckTest, WhatFitsBothPlacesAlikeIsNoMatch) {
  const auto bars = [](double u, double v) {
    return 120.0 + 40.0 * std::sin(2.0 * M_PI * u / 24.0) + 40.0 * std::sin(2.0 * M_PI * v / 19.0);
  };
  const StereoImages images = view(bars, [](float) { return 30.0F; });
  const ImagePoint place{static_cast<float>(kPlace.u_px), static_cast<float>(kPlace.v_px)};
  const StereoMeasurement own = align_stereo(images, place, {.disparity_px = 54.0F});
  ASSERT_TRUE(own.valid);
  const Scene scene(images, own, {.disparity_px = 30.0F, .ncc = own.ncc});
  EXPECT_FALSE(scene.settled(images).valid);
}

}  // namespace
}  // namespace egomod
