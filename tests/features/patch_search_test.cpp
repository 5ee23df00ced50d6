// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/patch_search.hpp"

#include <gtest/gtest.h>

#include "reference_kernels.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

Image poster(int du_px, int dv_px, double gain = 1.0) {
  const testing::SpottedTexture texture(220, 180, 3, 60.0, 6.0);
  return testing::painted(160, 120, [&](int u, int v) {
    return 20.0 + gain * (texture(u + 30 - du_px, v + 30 - dv_px) - 20.0);
  });
}

TEST(PatchSearchTest, FindsTheShiftOfEveryPatchWithinTheRadius) {
  const Image before = poster(0, 0);
  PatchSearch search;
  for (const auto& [du, dv] : {std::pair{0, 0}, {5, -8}, {-8, 8}, {3, 2}}) {
    const Image after = poster(du, dv, 0.8);
    for (int v = 20; v < 90; v += 11) {
      for (int u = 20; u < 130; u += 13) {
        SearchPatch patch;
        ASSERT_TRUE(copy_patch(before.view(), {u, v}, patch));
        const PatchSearchResult r = search.search(after.view(), patch, {u, v}, 8);
        ASSERT_TRUE(r.found);
        EXPECT_EQ(r.top_left, (PixelPosition{u + du, v + dv}));
        EXPECT_GT(r.ncc, 0.99F);
        EXPECT_LT(r.second_ncc, r.ncc);
      }
    }
  }
}

TEST(PatchSearchTest, EqualsAPlainSearchOverEveryPlace) {
  constexpr double kFloatRounding = 2e-6;
  const Image before = testing::flat_image(80, 60, 128.0, 40.0, 1);
  const Image after = testing::flat_image(80, 60, 128.0, 40.0, 2);
  SearchPatch patch;
  ASSERT_TRUE(copy_patch(before.view(), {30, 20}, patch));
  double best = -1.0;
  for (int v = 15; v <= 25; ++v)
    for (int u = 25; u <= 35; ++u)
      best = std::max(best, testing::reference_ncc(before.view(), 30, 20, after.view(), u, v, 8));
  PatchSearch search;
  EXPECT_NEAR(search.search(after.view(), patch, {30, 20}, 5).ncc, best, kFloatRounding);
}

TEST(PatchSearchTest, TheSecondBestTellsRepeatedTexture) {
  const Image image = testing::painted(160, 120, [](int u, int v) {
    return 120.0 + 50.0 * std::sin(2.0 * M_PI * u / 8.0) * std::sin(2.0 * M_PI * v / 8.0);
  });
  SearchPatch patch;
  ASSERT_TRUE(copy_patch(image.view(), {60, 60}, patch));
  PatchSearch search;
  EXPECT_GT(search.search(image.view(), patch, {60, 60}, 10).second_ncc, 0.98F);
}

TEST(PatchSearchTest, FindsNothingWithoutTextureOrOutside) {
  const Image wall = testing::flat_image(160, 120, 100.0, 0.0), textured = poster(0, 0);
  SearchPatch patch;
  ASSERT_TRUE(copy_patch(wall.view(), {60, 60}, patch));
  PatchSearch search;
  EXPECT_FALSE(search.search(textured.view(), patch, {60, 60}, 8).found);
  ASSERT_TRUE(copy_patch(textured.view(), {60, 60}, patch));
  EXPECT_FALSE(search.search(wall.view(), patch, {60, 60}, 8).found);
  EXPECT_FALSE(search.search(textured.view(), patch, {400, 60}, 8).found);
  EXPECT_FALSE(copy_patch(textured.view(), {153, 60}, patch));
  EXPECT_FALSE(copy_patch(textured.view(), {60, -1}, patch));
}

TEST(PatchSearchTest, StaysInsideAtTheEdges) {
  const Image image = poster(0, 0);
  SearchPatch patch;
  PatchSearch search;
  for (const PixelPosition p : {PixelPosition{0, 0}, {152, 0}, {0, 112}, {152, 112}}) {
    ASSERT_TRUE(copy_patch(image.view(), p, patch));
    EXPECT_EQ(search.search(image.view(), patch, p, PatchSearch::kMaxRadius_px).top_left, p);
  }
}

}  // namespace
}  // namespace egomod
