// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/noise_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egomod {
namespace {

constexpr double kNoisePairs_s = 1.0 / 30.0;
constexpr double kStatedSigma_px = 0.1;
constexpr double kModelFloor_px = 0.01;
constexpr double kRichTexture = 0.1, kPoorTexture = 0.01;

// Errs, unlike what is stated, with depth, texture and age.
double true_disparity_sigma_px(const NoiseKey& key) {
  return (key.depth_m > 8.0 ? 0.25 : 0.12) * (key.texture < 0.05 ? 2.0 : 1.0);
}
double true_pixel_sigma_px(const NoiseKey& key) {
  return 0.05 * (key.depth_m > 4.0 ? 2.0 : 1.0) * (key.age_pairs < 10.0 ? 1.5 : 1.0);
}

class LearningNoise : public ::testing::Test {
 protected:
  void add(const NoiseKey& key, int tracks, double scale = 1.0) {
    for (int i = 0; i < tracks; ++i) {
      const double pixel_px = scale * true_pixel_sigma_px(key);
      // Some are movers or mismatches.
      const double outlier = i % 10 == 0 ? 20.0 : 1.0;
      const double variance_px2 = kStatedSigma_px * kStatedSigma_px;
      model_.add(key,
                 {.u_px = outlier * pixel_px * normal_(random_),
                  .v_px = outlier * pixel_px * normal_(random_),
                  .disparity_px = outlier * scale * true_disparity_sigma_px(key) * normal_(random_),
                  .variance_u_px2 = variance_px2,
                  .variance_v_px2 = variance_px2,
                  .variance_disparity_px2 = variance_px2});
    }
  }

  void run(int pairs, double scale = 1.0) {
    for (int pair = 0; pair < pairs; ++pair) {
      for (const double depth_m : {3.0, 6.0, 12.0}) {
        for (const double texture : {kPoorTexture, kRichTexture}) {
          for (const double age_pairs : {5.0, 50.0}) add({depth_m, texture, age_pairs}, 20, scale);
        }
      }
      model_.learn(kNoisePairs_s);
    }
  }

  // Of what is stated, times the factor, to what is true.
  double pixel_ratio(const NoiseKey& key) const {
    return kStatedSigma_px * std::sqrt(model_.factors(key).pixel) / true_pixel_sigma_px(key);
  }
  double disparity_ratio(const NoiseKey& key) const {
    return kStatedSigma_px * std::sqrt(model_.factors(key).disparity) /
           true_disparity_sigma_px(key);
  }

  NoiseModel model_{kModelFloor_px};
  std::mt19937 random_{5};
  std::normal_distribution<double> normal_{0.0, 1.0};
};

// One in ten is an outlier, which moves the median by a few per cent.
TEST_F(LearningNoise, FindsWhatDependsOnDepthTextureAndAge) {
  run(300);
  for (const double depth_m : {3.0, 6.0, 12.0}) {
    for (const double texture : {kPoorTexture, kRichTexture}) {
      for (const double age_pairs : {5.0, 50.0}) {
        const NoiseKey key{depth_m, texture, age_pairs};
        EXPECT_NEAR(pixel_ratio(key), 1.12, 0.15) << depth_m << " " << texture << " " << age_pairs;
        EXPECT_NEAR(disparity_ratio(key), 1.12, 0.15)
            << depth_m << " " << texture << " " << age_pairs;
      }
    }
  }
}

TEST_F(LearningNoise, ReportsStandardDeviationsByDepth) {
  run(300);
  std::vector<NoiseBin> bins;
  model_.report(bins);
  ASSERT_EQ(bins.size(), 12U);
  for (const NoiseBin& bin : bins) {
    const NoiseKey key{0.5 * (bin.least_depth_m + bin.most_depth_m),
                       bin.is_rich ? kRichTexture : kPoorTexture, bin.is_old ? 50.0 : 5.0};
    EXPECT_NEAR(bin.disparity_sigma_px, 1.12 * true_disparity_sigma_px(key),
                0.15 * true_disparity_sigma_px(key));
    EXPECT_NEAR(bin.pixel_sigma_px, 1.12 * true_pixel_sigma_px(key),
                0.15 * true_pixel_sigma_px(key));
  }
}

TEST_F(LearningNoise, FollowsAChangeWithinSeconds) {
  run(150);
  const NoiseKey key{6.0, kRichTexture, 50.0};
  const double before = model_.factors(key).disparity;
  run(360, 2.0);
  EXPECT_NEAR(model_.factors(key).disparity / before, 4.0, 0.8);
}

TEST_F(LearningNoise, DrawsABinOfFewTracksToWhatIsCommon) {
  run(300);
  const NoiseKey known{12.0, kPoorTexture, 50.0}, unknown{30.0, kPoorTexture, 50.0};
  const double common = model_.factors(unknown).disparity;
  add(unknown, 10);
  model_.learn(kNoisePairs_s);
  EXPECT_NEAR(model_.factors(unknown).disparity, common, 0.1 * common);
  EXPECT_GT(model_.factors(known).disparity, 1.5 * common);
}

}  // namespace
}  // namespace egomod
