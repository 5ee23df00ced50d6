// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "simulator.hpp"
#include "small_world.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;

constexpr double kReadNoise = 1.8;        // a Kinect's at half light
constexpr double kOcclusionSlack = 0.02;  // of the depth
constexpr double kSteepDepth = 0.03;  // of the depth, from pixel to pixel: a border or seen flat

// A room where everything rests but the rig, and cameras that differ in nothing but noise.
World resting_room(double softness_px) {
  World world = test::world_of(test::small_room());
  world.camera.width_px = 320;
  world.camera.height_px = 240;
  world.camera.fx_px = world.camera.fy_px = 262.5;
  world.camera.cx_px = 159.5;
  world.camera.cy_px = 119.5;
  std::erase_if(world.things, [](const Thing& thing) { return thing.id > 0; });
  world.realism = {.softness_px = softness_px,
                   .read_noise = kReadNoise,
                   .shot_noise = 0.0,
                   .vignetting = 0.0,
                   .right_gain = 1.0,
                   .gain_drift = 0.0};
  return world;
}

// By cubic convolution, which leaves less of an error than the noise.
double interpolated(const Image& image, double u, double v) {
  const auto weights = [](double a) {
    return std::array<double, 4>{((-0.5 * a + 1.0) * a - 0.5) * a, (1.5 * a - 2.5) * a * a + 1.0,
                                 ((-1.5 * a + 2.0) * a + 0.5) * a, (0.5 * a - 0.5) * a * a};
  };
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const auto across = weights(u - x);
  const auto down = weights(v - y);
  double sum = 0.0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      sum += down[static_cast<std::size_t>(j)] * across[static_cast<std::size_t>(i)] *
             image.row(y + j - 1)[x + i - 1];
    }
  }
  return sum;
}

struct Look {
  Image image;
  Eigen::Isometry3d T_first_camera;
  std::vector<float> depth_m;
};

// Differences between what a camera saw and what another one would have, by the truth's depth and
// pose, where both see the same surface.
std::vector<double> residuals(const Look& from, const Look& to, const StereoCamera& c) {
  std::vector<double> out;
  const Eigen::Isometry3d T_to_from = to.T_first_camera.inverse() * from.T_first_camera;
  const auto depth = [&](const Look& look, int u, int v) -> double {
    return look.depth_m[static_cast<std::size_t>(v * c.width_px + u)];
  };
  const auto is_smooth = [&](const Look& look, int u, int v) {
    const double z = depth(look, u, v);
    return std::abs(depth(look, u + 1, v) - z) < kSteepDepth * z &&
           std::abs(depth(look, u - 1, v) - z) < kSteepDepth * z &&
           std::abs(depth(look, u, v + 1) - z) < kSteepDepth * z &&
           std::abs(depth(look, u, v - 1) - z) < kSteepDepth * z;
  };
  for (int v = 2; v < c.height_px - 2; ++v) {
    for (int u = 2; u < c.width_px - 2; ++u) {
      if (!is_smooth(from, u, v)) continue;
      const Vector3d ray((u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px, 1.0);
      const Vector3d P = T_to_from * (ray * depth(from, u, v));
      const double x = c.fx_px * P.x() / P.z() + c.cx_px;
      const double y = c.fy_px * P.y() / P.z() + c.cy_px;
      if (x < 2 || y < 2 || x > c.width_px - 3 || y > c.height_px - 3) continue;
      const int i = static_cast<int>(std::lround(x));
      const int j = static_cast<int>(std::lround(y));
      if (!is_smooth(to, i, j)) continue;
      if (std::abs(depth(to, i, j) - P.z()) > kOcclusionSlack * P.z()) continue;
      out.push_back(interpolated(to.image, x, y) - from.image.row(v)[u]);
    }
  }
  return out;
}

Look look(Simulator& simulator, std::uint64_t number) {
  Look out;
  Truth truth;
  simulator.take_image(Eye::kLeft, number, out.image);
  simulator.take_truth(number, truth);
  out.T_first_camera = truth.T_first_current;
  out.depth_m = truth.buffers.depth_m;
  return out;
}

struct Residual {
  double mean;
  double rms;
};

Residual residual(double softness_px) {
  Simulator simulator(resting_room(softness_px));
  const Look from = look(simulator, 3);
  const Look to = look(simulator, 9);
  const auto differences = residuals(from, to, simulator.world().camera);
  EXPECT_GT(differences.size(), 40000U);
  double sum = 0.0;
  double squares = 0.0;
  for (const double d : differences) {
    sum += d;
    squares += d * d;
  }
  const auto count = static_cast<double>(differences.size());
  return {sum / count, std::sqrt(squares / count)};
}

// Of one pixel, and of the sixteen that are mixed, whose squared weights come to 0.7 in the mean.
const double kNoise = kReadNoise * std::sqrt(1.7);
constexpr double kBias = 0.2;

TEST(Photometry, OneViewWarpedByTheTruthIsTheOtherButForNoise) {
  const Residual soft = residual(0.5);
  EXPECT_LT(std::abs(soft.mean), kBias);
  EXPECT_LT(soft.rms, 1.25 * kNoise);
}

// Joints of bricks as thin as a pixel are more than any interpolation between pixels can follow.
TEST(Photometry, OfASharpLensLeavesNoMoreThanInterpolationDoes) {
  const Residual sharp = residual(0.0);
  EXPECT_LT(std::abs(sharp.mean), kBias);
  EXPECT_LT(sharp.rms, 1.6 * kNoise);
}

}  // namespace
}  // namespace egomod::sim
