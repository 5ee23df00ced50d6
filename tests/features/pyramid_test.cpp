// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/pyramid.hpp"

#include <gtest/gtest.h>

#include "reference_kernels.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

TEST(PyramidTest, EveryLevelIsTheBinomialOfTheOneBelow) {
  const Image image = testing::flat_image(161, 123, 128.0, 80.0);
  Pyramid pyramid;
  pyramid.build(image.view(), 3);
  ASSERT_EQ(pyramid.levels(), 3);
  for (int k = 1; k < 3; ++k) {
    const ImageView fine = pyramid.level(k - 1), coarse = pyramid.level(k);
    ASSERT_EQ(coarse.width_px, fine.width_px / 2);
    ASSERT_EQ(coarse.height_px, fine.height_px / 2);
    for (int v = 0; v < coarse.height_px; ++v)
      for (int u = 0; u < coarse.width_px; ++u)
        ASSERT_EQ(coarse.row(v)[u], testing::reference_half_pixel(fine, u, v)) << u << " " << v;
  }
}

ImagePoint brightest_centroid(const ImageView& image) {
  double total = 0, u_total = 0, v_total = 0;
  for (int v = 0; v < image.height_px; ++v) {
    for (int u = 0; u < image.width_px; ++u) {
      const double weight = image.row(v)[u];
      total += weight;
      u_total += weight * u;
      v_total += weight * v;
    }
  }
  return {static_cast<float>(u_total / total), static_cast<float>(v_total / total)};
}

TEST(PyramidTest, ASpotLiesWhereTheConventionSays) {
  constexpr float kCentroidTolerance_px = 0.02F;  // grey values are whole numbers
  const Image image = testing::painted(320, 240, [](int u, int v) {
    const double du = (u - 150.3) / 14.0, dv = (v - 97.6) / 14.0;
    return 250.0 * std::exp(-0.5 * (du * du + dv * dv));
  });
  Pyramid pyramid;
  pyramid.build(image.view(), 4);
  const ImagePoint full = brightest_centroid(image.view());
  for (int k = 1; k < 4; ++k) {
    const ImagePoint seen = brightest_centroid(pyramid.level(k)), wanted = to_level(full, k);
    EXPECT_NEAR(seen.u_px, wanted.u_px, kCentroidTolerance_px) << k;
    EXPECT_NEAR(seen.v_px, wanted.v_px, kCentroidTolerance_px) << k;
  }
}

TEST(PyramidTest, StopsBeforeALevelGetsTooSmall) {
  const Image image = testing::flat_image(100, 50, 128.0, 10.0);
  Pyramid pyramid;
  pyramid.build(image.view(), Pyramid::kMaxLevels);
  EXPECT_EQ(pyramid.levels(), 2);  // 25 rows would become 12
}

TEST(PyramidTest, ReusesItsBuffers) {
  const Image image = testing::flat_image(320, 240, 128.0, 10.0);
  Pyramid pyramid;
  pyramid.build(image.view(), 4);
  const std::uint8_t* const first = pyramid.level(2).data;
  pyramid.build(image.view(), 4);
  EXPECT_EQ(pyramid.level(2).data, first);
}

}  // namespace
}  // namespace egomod
