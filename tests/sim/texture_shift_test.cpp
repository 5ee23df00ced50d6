// SPDX-License-Identifier: Apache-2.0
// Aliases crawl: they move otherwise than what they are seen on, and look like motion.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "materials.hpp"
#include "renderer.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;

constexpr double kCrawlRms_px = 0.025;
constexpr double kCrawlWorst_px = 0.07;  // of one row
constexpr double kStep_px = 0.1;
constexpr int kSteps = 10;
constexpr double kCamera_m = 0.45;    // above the floor
constexpr double kMinEnergy = 600.0;  // of a row's gradient: a row without texture shows no shift

StereoCamera small_camera() {
  return {.fx_px = 525.0,
          .fy_px = 525.0,
          .cx_px = 79.5,
          .cy_px = 79.5,
          .baseline_m = 0.3,
          .width_px = 160,
          .height_px = 160};
}

// A wall at the distance, or, with 0, the floor.
test_support::Scene surface(const std::string& name, double distance_m) {
  const bool is_floor = distance_m == 0.0;
  const double width_m = is_floor ? 4.0 : 0.35 * distance_m;
  const double length_m = is_floor ? 12.0 : 0.35 * distance_m;
  test_support::Patch patch;
  patch.corner_m = is_floor ? Vector3d(-2, kCamera_m, 1.0)
                            : Vector3d(-0.5 * width_m, -0.5 * length_m, distance_m);
  patch.edge_s_m = Vector3d(width_m, 0, 0);
  patch.edge_t_m = is_floor ? Vector3d(0, 0, length_m) : Vector3d(0, length_m, 0);
  patch.is_seen_flat = is_floor;
  test_support::Scene scene;
  patch.texture =
      add_texture(scene, width_m, length_m, 0.004, material(name, width_m, length_m, 7));
  scene.bodies.emplace_back().patches.push_back(patch);
  return scene;
}

// A row as a tracker sees it: without what lies next to the sampling limit.
std::vector<double> smoothed(const Image& image, int v) {
  const std::uint8_t* p = image.row(v);
  std::vector<double> out;
  for (int u = 2; u < image.width_px() - 2; ++u) {
    out.push_back((p[u - 2] + 4.0 * p[u - 1] + 6.0 * p[u] + 4.0 * p[u + 1] + p[u + 2]) / 16.0);
  }
  return out;
}

// How far the row moved to the left: least squares on the mean gradient of both images, which is
// exact to the second order.
struct RowShift {
  double shift_px;
  double energy;
};
RowShift row_shift(const std::vector<double>& from, const std::vector<double>& to) {
  double product = 0.0;
  double energy = 0.0;
  const auto slope = [](const std::vector<double>& row, std::size_t u) {
    return (8.0 * (row[u + 1] - row[u - 1]) - (row[u + 2] - row[u - 2])) / 12.0;
  };
  for (std::size_t u = 2; u + 2 < from.size(); ++u) {
    const double gradient = 0.5 * (slope(from, u) + slope(to, u));
    product += gradient * (to[u] - from[u]);
    energy += gradient * gradient;
  }
  return {product / energy, energy};
}

struct Crawl {
  int rows = 0;
  double rms_px = 0.0;
  double worst_px = 0.0;
};

// Steps of a tenth of a pixel, summed up: what each row shows of its true way.
Crawl crawl(const test_support::Scene& scene, double distance_m) {
  const StereoCamera camera = small_camera();
  const Renderer renderer(scene, camera);
  const auto canvas = renderer.make_canvas(camera.width_px, camera.height_px);
  const auto depth_m = [&](int v) {
    return distance_m > 0.0 ? distance_m : kCamera_m * camera.fy_px / (v - camera.cy_px);
  };
  const double nearest_m = depth_m(camera.height_px - 1);
  const double step_m = kStep_px * nearest_m / camera.fx_px;
  Image before;
  Image now;
  std::vector<double> moved_px(static_cast<std::size_t>(camera.height_px), 0.0);
  Crawl out;
  double sum = 0.0;
  for (int step = 0; step <= kSteps; ++step) {
    const Eigen::Isometry3d T(Eigen::Translation3d(-step_m * step, 0, 0));
    const View view{0.0, T, 0, camera.height_px, 0};
    renderer.draw(canvas, pinhole_of(camera), {&view, 1});
    renderer.read(canvas, now);
    const int first = distance_m > 0.0 ? 0 : 100;  // there the floor is 11.5 m away
    for (int v = first; step > 0 && v < camera.height_px; ++v) {
      const RowShift seen = row_shift(smoothed(before, v), smoothed(now, v));
      double& way_px = moved_px[static_cast<std::size_t>(v)];
      way_px += seen.shift_px;
      if (seen.energy < kMinEnergy) continue;
      const double error = way_px - step * step_m * camera.fx_px / depth_m(v);
      out.worst_px = std::max(out.worst_px, std::abs(error));
      sum += error * error;
      ++out.rows;
    }
    std::swap(before, now);
  }
  out.rms_px = std::sqrt(sum / std::max(1, out.rows));
  return out;
}

void expect_no_crawl(const std::string& material, double distance_m) {
  const Crawl seen = crawl(surface(material, distance_m), distance_m);
  std::printf("[  figures ] %s at %.1f m: %d rows, rms %.4f, worst %.4f px\n", material.c_str(),
              distance_m, seen.rows, seen.rms_px, seen.worst_px);
  EXPECT_GT(seen.rows, 200) << material << " at " << distance_m;
  EXPECT_LT(seen.rms_px, kCrawlRms_px) << material << " at " << distance_m;
  EXPECT_LT(seen.worst_px, kCrawlWorst_px) << material << " at " << distance_m;
}

TEST(TextureShift, FollowsTheCameraAtEveryDistance) {
  for (const double distance_m : {1.0, 2.0, 4.0, 8.0}) {
    expect_no_crawl("carton", distance_m);
    expect_no_crawl("bricks", distance_m);
  }
}

TEST(TextureShift, FollowsTheCameraOnTheFloorToTheHorizon) {
  expect_no_crawl("tiles", 0.0);
  expect_no_crawl("wood", 0.0);
}

}  // namespace
}  // namespace egomod::sim
