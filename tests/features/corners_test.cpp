// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/corners.hpp"

#include <gtest/gtest.h>

#include <map>

#include "noise.hpp"
#include "reference_kernels.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 240;

std::vector<Corner> corners_of(const Image& image, const std::vector<ImagePoint>& occupied = {},
                               const CornerConfig& config = {}, float room_factor = 1.0F) {
  CornerDetector detector(config);
  std::vector<Corner> corners;
  detector.detect(image.view(), occupied, room_factor, corners);
  return corners;
}

Image poster(double contrast, double noise_sigma = 0.0) {
  const testing::SpottedTexture texture(kWidth_px, kHeight_px, 5, contrast);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  return testing::painted(kWidth_px, kHeight_px, [&](int u, int v) {
    return texture(u, v) + noise_sigma * noise(random);
  });
}

double distance(PixelPosition a, PixelPosition b) {
  return std::hypot(a.u_px - b.u_px, a.v_px - b.v_px);
}

TEST(CornerDetectorTest, FindsTheCornersOfARectangleToThePixel) {
  const Image image = testing::painted(kWidth_px, kHeight_px, [](int u, int v) {
    return u >= 100 && u < 180 && v >= 90 && v < 150 ? 180 : 80;
  });
  const auto corners = corners_of(image);
  ASSERT_EQ(corners.size(), 4U);
  for (const PixelPosition truth : {PixelPosition{100, 90}, {179, 90}, {100, 149}, {179, 149}}) {
    double nearest = 1e9;
    for (const Corner& c : corners) nearest = std::min(nearest, distance(c.position, truth));
    EXPECT_LE(nearest, 2.0);
  }
  for (const Corner& c : corners) EXPECT_EQ(c.kind, CornerKind::kBright);
}

TEST(CornerDetectorTest, ReturnsNothingFromAWhiteWall) {
  EXPECT_TRUE(corners_of(testing::flat_image(kWidth_px, kHeight_px, 230.0, 0.0)).empty());
  for (const double sigma : {0.4, 1.0, 2.0, 4.0, 10.0})
    EXPECT_TRUE(corners_of(testing::flat_image(kWidth_px, kHeight_px, 230.0, sigma)).empty())
        << sigma;
}

TEST(CornerDetectorTest, ReturnsNothingFromTheNoiseOfADarkImage) {
  // Below black most pixels are 0 and the rest are specks.
  for (const double black : {0.0, -3.0, -8.0})
    for (const double sigma : {2.0, 5.0, 12.0})
      EXPECT_EQ(corners_of(testing::flat_image(kWidth_px, kHeight_px, black, sigma)).size(), 0U)
          << black << " " << sigma;
}

TEST(CornerDetectorTest, ReturnsNothingFromAShadedWall) {
  EXPECT_TRUE(corners_of(testing::painted(kWidth_px, kHeight_px, [](int u, int v) {
                return 60.0 + 0.3 * u + 0.2 * v;
              })).empty());
}

TEST(CornerDetectorTest, ReturnsNothingFromStraightEdges) {
  EXPECT_TRUE(corners_of(testing::painted(kWidth_px, kHeight_px, [](int u, int v) {
                return u + 0.37 * v > 200.0 ? 160.0 : 90.0;
              })).empty());
}

TEST(CornerDetectorTest, FindsCornersInLowTexture) {
  constexpr std::size_t kEnough = 100;
  EXPECT_GT(corners_of(poster(20.0, 0.5)).size(), kEnough);
}

TEST(NoiseTest, IsMeasuredOnAFlatImage) {
  for (const double sigma : {1.0, 3.0, 8.0}) {
    const Image image = testing::flat_image(kWidth_px, kHeight_px, 128.0, sigma);
    EXPECT_NEAR(estimate_noise_sigma(image.view()), sigma, 0.15 * sigma + 0.1);
  }
}

TEST(CornerDetectorTest, TakesTheNoiseOutOfTheEigenvalue) {
  constexpr double kTolerance = 0.12;
  const auto sum_of = [](const std::vector<Corner>& corners, std::size_t count) {
    double total = 0;
    for (std::size_t i = 0; i < count; ++i) total += corners[i].min_eigenvalue;
    return total;
  };
  const auto clean = corners_of(poster(60.0)), noisy = corners_of(poster(60.0, 4.0));
  const std::size_t count = std::min<std::size_t>(48, std::min(clean.size(), noisy.size()));
  ASSERT_EQ(count, 48U);
  EXPECT_NEAR(sum_of(noisy, count) / sum_of(clean, count), 1.0, kTolerance);
}

TEST(CornerDetectorTest, KeepsDistanceBorderAndTheRoomOfEveryBucket) {
  const CornerConfig config{.bucket_px = 40, .corners_per_bucket = 4, .min_distance_px = 7};
  const auto corners = corners_of(poster(60.0), {}, config);
  std::map<std::pair<int, int>, int> per_bucket;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const PixelPosition p = corners[i].position;
    EXPECT_GE(std::min({p.u_px, p.v_px, kWidth_px - 1 - p.u_px, kHeight_px - 1 - p.v_px}),
              config.border_px);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE(distance(p, corners[j].position), config.min_distance_px);
    EXPECT_LT(corners[i].rank, config.corners_per_bucket);
  }
  EXPECT_GT(corners.size(), 150U);  // of 48 buckets with room for 4
}

std::vector<ImagePoint> places_of(const std::vector<Corner>& corners) {
  std::vector<ImagePoint> places;
  places.reserve(corners.size());
  for (const Corner& c : corners)
    places.push_back({static_cast<float>(c.position.u_px), static_cast<float>(c.position.v_px)});
  return places;
}

TEST(CornerDetectorTest, OldTracksTakeTheirPlacesFirst) {
  const CornerConfig config{.corners_per_bucket = 2};
  const Image image = poster(60.0);
  const auto first = corners_of(image, {}, config);
  const std::vector<ImagePoint> occupied = places_of(first);
  const auto full = corners_of(image, occupied, config);
  EXPECT_LT(full.size(), first.size() / 10);
  // With room for one more in each bucket, none of them is near an old one.
  for (const Corner& c : corners_of(image, occupied, {.corners_per_bucket = 3}))
    for (const Corner& old : first)
      EXPECT_GE(distance(c.position, old.position), config.min_distance_px);
}

TEST(CornerDetectorTest, WhatShowsFewMovingTracksComesFirst) {
  const Image image = poster(60.0);
  const std::vector<ImagePoint> occupied =
      places_of(corners_of(image, {}, {.corners_per_bucket = 2}));
  const ImagePoint middle{0.5F * kWidth_px, 0.5F * kHeight_px};
  constexpr float kBucketAndNext_px = 81.0F;
  const auto first_with = [&](std::size_t movers) {
    CornerDetector detector({.corners_per_bucket = 3});
    int first = 0;
    std::vector<Corner> corners;
    for (int i = 0; i < CornerDetector::kPatience; ++i) {
      detector.detect(image.view(), occupied, 1.0F, corners,
                      std::vector<ImagePoint>(movers, middle));
      bool others_have_come = false;
      for (const Corner& c : corners) {
        others_have_come = others_have_come || c.rank >= 0;
        if (c.rank >= 0) continue;
        ++first;
        EXPECT_FALSE(others_have_come);
        EXPECT_LT(std::abs(static_cast<float>(c.position.u_px) - middle.u_px), kBucketAndNext_px);
        EXPECT_LT(std::abs(static_cast<float>(c.position.v_px) - middle.v_px), kBucketAndNext_px);
      }
    }
    return first;
  };
  EXPECT_EQ(first_with(0), 0);
  EXPECT_EQ(first_with(1), 0) << "one may be a mistake";
  EXPECT_GE(first_with(2), 4);
  EXPECT_GE(first_with(6), 4);
  EXPECT_EQ(first_with(7), 0) << "so many are enough";
}

TEST(CornerDetectorTest, WhatMovesAllOverTheImageComesFirstInFewPlacesOnly) {
  const Image image = poster(60.0);
  std::vector<ImagePoint> movers;
  for (int u = 60; u < kWidth_px; u += 120)
    for (int v = 60; v < kHeight_px; v += 120)
      movers.insert(movers.end(), 3, {static_cast<float>(u), static_cast<float>(v)});
  CornerDetector detector({});
  std::vector<Corner> corners;
  for (int call = 0; call < 2; ++call) {
    detector.detect(image.view(), {}, 1.0F, corners, movers);
    const auto others =
        std::find_if(corners.begin(), corners.end(), [](const Corner& c) { return c.rank >= 0; });
    EXPECT_EQ(others - corners.begin(), CornerDetector::kMostForMovers);
  }
}

TEST(CornerDetectorTest, TriesBucketsThatStayEmptyInTurns) {
  const Image image = poster(60.0);
  CornerDetector detector({});
  std::vector<Corner> corners;
  const std::vector<ImagePoint> lonely{{20.0F, 20.0F}};
  detector.detect(image.view(), lonely, 1.0F, corners);
  const std::size_t all = corners.size();
  // Nobody takes what is found: the room stays, and each bucket has its turn once in kPatience
  // calls.
  std::size_t total = 0;
  for (int i = 0; i < CornerDetector::kPatience; ++i) {
    detector.detect(image.view(), lonely, 1.0F, corners);
    EXPECT_LT(corners.size(), 5 * all / (4 * CornerDetector::kPatience));
    total += corners.size();
  }
  EXPECT_NEAR(static_cast<double>(total), static_cast<double>(all), 0.1 * static_cast<double>(all));
  detector.detect(image.view(), {}, 1.0F, corners);
  EXPECT_GE(corners.size(), all);
}

TEST(CornerDetectorTest, OrdersByRankThenStrength) {
  const auto corners = corners_of(poster(60.0));
  for (std::size_t i = 1; i < corners.size(); ++i) {
    ASSERT_GE(corners[i].rank, corners[i - 1].rank);
    if (corners[i].rank == corners[i - 1].rank) {
      ASSERT_LE(corners[i].min_eigenvalue, corners[i - 1].min_eigenvalue);
    }
  }
}

TEST(CornerDetectorTest, SurvivesImagesTooSmallForIt) {
  for (const int side : {1, 8, 17, 24})
    EXPECT_TRUE(corners_of(testing::flat_image(side, side, 100.0, 0.0)).empty());
}

}  // namespace
}  // namespace egomod
