// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/group_shape.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace egomod {
namespace {

struct Row {
  std::vector<PointSample> points;
  std::vector<Grouper::Index> all;

  explicit Row(std::initializer_list<double> u_px) {
    for (const double u : u_px) points.emplace_back().pixel_px = {u, 100.0};
    all.resize(points.size());
    std::iota(all.begin(), all.end(), Grouper::Index{0});
  }
  [[nodiscard]] std::size_t stray(double least_px) const { return stray_of(points, all, least_px); }
};

TEST(Stray, IsOneThatIsFartherBesideTheOthersThanTheyAreWide) {
  EXPECT_EQ(Row({110.0, 60.0, 100.0, 125.0, 130.0}).stray(20.0), 1U);
  EXPECT_EQ(Row({110.0, 100.0, 125.0, 170.0, 130.0}).stray(20.0), 3U);
}

TEST(Stray, IsNoneNearTheOthersOrNoFartherThanTheyAreWide) {
  EXPECT_EQ(Row({110.0, 60.0, 100.0, 125.0, 130.0}).stray(50.0), 5U) << "a foot ahead";
  EXPECT_EQ(Row({110.0, 60.0, 100.0, 125.0, 145.0}).stray(20.0), 5U) << "a sparse body";
}

TEST(Stray, IsNoneOfTwoOnOneSideOrOfThreePoints) {
  EXPECT_EQ(Row({60.0, 62.0, 100.0, 105.0, 110.0}).stray(20.0), 5U);
  EXPECT_EQ(Row({60.0, 100.0, 105.0}).stray(20.0), 3U);
}

TEST(Shrunk, KeepsAShareOfWhatWasBeyond) {
  const PixelRect before{100.0F, 50.0F, 200.0F, 150.0F};
  const PixelRect now{120.0F, 40.0F, 180.0F, 160.0F};
  const PixelRect kept = shrunk(before, now, 0.75);
  EXPECT_FLOAT_EQ(kept.u_min_px, 105.0F);
  EXPECT_FLOAT_EQ(kept.u_max_px, 195.0F);
  EXPECT_FLOAT_EQ(kept.v_min_px, 40.0F) << "it grows at once";
  EXPECT_FLOAT_EQ(kept.v_max_px, 160.0F);
}

TEST(Shrunk, OutOfWhatWasOutOfViewIsAsItIs) {
  const PixelRect kept = shrunk({0.0F, 0.0F, -1.0F, -1.0F}, {10.0F, 20.0F, 30.0F, 40.0F}, 0.75);
  EXPECT_FLOAT_EQ(kept.u_min_px, 10.0F);
  EXPECT_FLOAT_EQ(kept.v_max_px, 40.0F);
}

}  // namespace
}  // namespace egomod
