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
    return settle_by_neighbours(images, Skew(), store, store.points().back());
  }
  TrackStore store{4};
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
