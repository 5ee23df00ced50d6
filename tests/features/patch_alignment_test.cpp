// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/patch_alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>

#include "synthetic_texture.hpp"

namespace egomod {
namespace {

using testing::painted;
using testing::WaveTexture;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kU = 32;
constexpr int kV = 24;
constexpr unsigned kTextures = 20;
constexpr double kMaxBias_px = 0.02;
constexpr double kMaxError_px = 0.1;  // of a single texture: interpolation, 8-bit rounding
constexpr double kMaxWarpError = 0.04;
constexpr double kMaxSlopeError = 0.12;  // a weak prior pulls it towards zero
constexpr float kMinPlaneNcc = 0.93F;    // before the last step: slopes come later than disparity

Image view_of(const WaveTexture& texture) { return painted(kWidth, kHeight, std::cref(texture)); }

// A second image in which the template at (kU, kV) is seen at `to` under `A`.
Image warped(const WaveTexture& texture, const Eigen::Matrix2d& A, const Eigen::Vector2d& to,
             double gain, double offset) {
  const Eigen::Matrix2d inverse = A.inverse();
  return painted(kWidth, kHeight, [&](int u, int v) {
    const Eigen::Vector2d p = Eigen::Vector2d(kU, kV) + inverse * (Eigen::Vector2d(u, v) - to);
    return gain * texture(p.x(), p.y()) + offset;
  });
}

struct Case {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  double gain = 1.0;
  double offset = 0.0;
};

// A start as a track has it: the warp of the pair before, a tenth of the way behind.
AffineWarp carried(const Eigen::Matrix2d& A, const Eigen::Vector2d& position) {
  const Eigen::Matrix2d start = 0.9 * A + 0.1 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2f m = start.cast<float>();
  return {.u_px = static_cast<float>(position.x()),
          .v_px = static_cast<float>(position.y()),
          .a = m(0, 0),
          .b = m(0, 1),
          .c = m(1, 0),
          .d = m(1, 1)};
}

// Aligns many textures under one warp, each with another sub-pixel shift.
void expect_found(const Case& c) {
  Eigen::Vector2d total = Eigen::Vector2d::Zero();
  for (unsigned seed = 0; seed < kTextures; ++seed) {
    const WaveTexture texture(seed);
    const Eigen::Vector2d to(29.0 + 0.13 * seed, 22.0 + 0.29 * seed);
    const Image first = view_of(texture);
    const Image second = warped(texture, c.A, to, c.gain, c.offset);
    AffineTemplate patch;
    build_template(first.view(), kU, kV, patch);
    AffineWarp warp = carried(c.A, to + Eigen::Vector2d(0.6, -0.5));
    EXPECT_GT(align(second.view(), patch, 30, warp).ncc, 0.99F) << "texture " << seed;
    const Eigen::Vector2d error = Eigen::Vector2d(warp.u_px, warp.v_px) - to;
    EXPECT_LT(error.norm(), kMaxError_px) << "texture " << seed;
    total += error;
    Eigen::Matrix2d A;
    A << warp.a, warp.b, warp.c, warp.d;
    EXPECT_LT((A - c.A).cwiseAbs().maxCoeff(), kMaxWarpError) << "texture " << seed;
  }
  EXPECT_LT(total.norm() / kTextures, kMaxBias_px);
}

TEST(AffineAlignment, FindsShiftsWithoutBias) { expect_found({}); }

TEST(AffineAlignment, FindsScaleShearAndRotation) {
  Eigen::Matrix2d A;
  A << 1.12, 0.15, -0.1, 0.93;
  expect_found({.A = A});
}

TEST(AffineAlignment, IgnoresGainAndOffset) { expect_found({.gain = 0.6, .offset = 30.0}); }

// Points that leave their pixels lag behind in coarse textures and lead in fine ones. Over all
// waves that rooms show the two must balance, or the rig lags that leaves its place.
TEST(AffineAlignment, SmallShiftsAreFoundWholeOnAverage) {
  constexpr double kShift_px = 0.12;
  constexpr double kMaxLag_px = 0.008;
  constexpr unsigned kManyTextures = 100;
  Eigen::Vector2d total = Eigen::Vector2d::Zero();
  for (unsigned seed = 0; seed < kManyTextures; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> radians_per_px(0.4, 1.7);
    std::uniform_real_distribution<double> phase(0.0, 2.0 * M_PI);
    std::array<Eigen::Vector4d, 8> waves;
    for (Eigen::Vector4d& w : waves)
      w = {radians_per_px(random), phase(random), radians_per_px(random), phase(random)};
    const auto texture = [&](double u, double v) {
      double sum = 0.0;
      for (const Eigen::Vector4d& w : waves)
        sum += std::sin(w[0] * u + w[1]) + std::sin(w[2] * v + w[3]);
      return 128.0 + 20.0 * sum;
    };
    const Image first = painted(kWidth, kHeight, texture);
    const Image second = painted(
        kWidth, kHeight, [&](int u, int v) { return texture(u - kShift_px, v - kShift_px); });
    AffineTemplate patch;
    build_template(first.view(), kU, kV, patch);
    AffineWarp warp{.u_px = kU, .v_px = kV};
    for (int k = 0; k < 5; ++k) EXPECT_GT(align(second.view(), patch, 10, warp).ncc, 0.98F);
    total += Eigen::Vector2d(warp.u_px - kU - kShift_px, warp.v_px - kV - kShift_px);
  }
  EXPECT_LT((total / kManyTextures).cwiseAbs().maxCoeff(), kMaxLag_px);
}

TEST(AffineAlignment, PatchThatLeavesTheImageHasNoCorrelation) {
  const Image image = view_of(WaveTexture(3));
  AffineTemplate patch;
  build_template(image.view(), kU, kV, patch);
  for (const AffineWarp start :
       {AffineWarp{.u_px = 5.0F, .v_px = 24.0F}, AffineWarp{.u_px = 59.0F, .v_px = 24.0F},
        AffineWarp{.u_px = 32.0F, .v_px = -400.0F},
        AffineWarp{.u_px = 32.0F, .v_px = 24.0F, .a = 50.0F}}) {
    AffineWarp warp = start;
    EXPECT_EQ(align(image.view(), patch, 5, warp).ncc, -1.0F);
  }
}

TEST(AffineAlignment, FlatImagesStayFinite) {
  const Image flat = painted(kWidth, kHeight, [](int, int) { return 255.0; });
  AffineTemplate patch;
  build_template(flat.view(), kU, kV, patch);
  AffineWarp warp{.u_px = 30.3F, .v_px = 25.7F};
  const AlignmentResult result = align(flat.view(), patch, 10, warp);
  EXPECT_LT(result.ncc, 0.5F);
  EXPECT_TRUE(std::isfinite(result.ncc));
  EXPECT_TRUE(std::isfinite(warp.u_px + warp.v_px + warp.a + warp.b + warp.c + warp.d));
}

// u_right = u - (disparity + slope_u (u - kU) + slope_v (v - kV)), solved for u.
Image right_view(const WaveTexture& texture, double disparity_px, double slope_u, double slope_v) {
  return painted(kWidth, kHeight, [&](int u_right, int v) {
    const double u = (u_right + disparity_px - slope_u * kU + slope_v * (v - kV)) / (1.0 - slope_u);
    return 1.1 * texture(u, v) - 7.0;
  });
}

void expect_plane_found(double slope_u, double slope_v) {
  double bias_px = 0.0;
  for (unsigned seed = 0; seed < kTextures; ++seed) {
    const WaveTexture texture(seed);
    const double disparity_px = 10.0 + 0.37 * seed;
    const Image left = view_of(texture);
    const Image right = right_view(texture, disparity_px, slope_u, slope_v);
    PlaneTemplate patch;
    build_template(left.view(), kU, kV, patch);
    PlaneWarp warp{.u_px = static_cast<float>(kU - disparity_px + 0.6), .v_px = kV};
    EXPECT_GT(align(right.view(), patch, 30, warp).ncc, kMinPlaneNcc) << "texture " << seed;
    EXPECT_NEAR(kU - warp.u_px, disparity_px, kMaxError_px) << "texture " << seed;
    EXPECT_NEAR(warp.slope_u, slope_u, kMaxSlopeError) << "texture " << seed;
    EXPECT_NEAR(warp.slope_v, slope_v, kMaxSlopeError) << "texture " << seed;
    bias_px += kU - warp.u_px - disparity_px;
  }
  EXPECT_LT(std::abs(bias_px / kTextures), kMaxBias_px);
}

TEST(PlaneAlignment, FindsDisparityOfFlatPatches) { expect_plane_found(0.0, 0.0); }
TEST(PlaneAlignment, FindsDisparityAndSlopeOfFloors) { expect_plane_found(0.0, 0.5); }
TEST(PlaneAlignment, FindsDisparityAndSlopeOfWalls) { expect_plane_found(-0.2, 0.1); }

// With noise in both images, the residual and the texture must tell how far the estimates scatter.
TEST(AffineAlignment, ResidualAndTextureTellTheScatter) {
  constexpr double kNoise = 4.0;
  double predicted_px2 = 0.0;
  double measured_px2 = 0.0;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kNoise);
  for (unsigned seed = 0; seed < 200; ++seed) {
    const WaveTexture texture(seed % kTextures);
    const auto noisy = [&](int u, int v) { return texture(u, v) + noise(random); };
    const Image first = painted(kWidth, kHeight, noisy);
    const Image second = painted(kWidth, kHeight, noisy);
    AffineTemplate patch;
    build_template(first.view(), kU, kV, patch);
    AffineWarp warp{.u_px = kU + 0.2F, .v_px = kV - 0.2F};
    const AlignmentResult result = align(second.view(), patch, 20, warp);
    const double trace = patch.inverse_hessian[0] + patch.inverse_hessian[7];
    predicted_px2 += 2.0 * (1.0 - result.ncc) / patch_effective_samples() * trace;
    measured_px2 += std::pow(warp.u_px - kU, 2) + std::pow(warp.v_px - kV, 2);
  }
  EXPECT_GT(measured_px2, 0.25 * predicted_px2);
  EXPECT_LT(measured_px2, 4.0 * predicted_px2);
}

}  // namespace
}  // namespace egomod
