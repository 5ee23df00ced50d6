// SPDX-License-Identifier: Apache-2.0
#include "materials.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::sim {
namespace {

using test_support::Paint;
using test_support::plaster;
using test_support::value_noise;

constexpr double kStorey_m = 3.0;
constexpr double kWindowPitch_m = 2.2;

// Brick with rows of windows, each with its own curtains.
Paint facade(double height_m, std::uint32_t seed) {
  const Paint wall = test_support::bricks(seed);
  return [=](double s, double t) {
    const double up = height_m - t;
    const double column = std::floor(s / kWindowPitch_m);
    const double storey = std::floor(up / kStorey_m);
    const double ds = s - column * kWindowPitch_m - 0.55;
    const double dt = up - storey * kStorey_m - 0.9;
    const bool frame = ds > -0.08 && ds < 1.18 && dt > -0.08 && dt < 1.58;
    if (!frame) return wall(s, t);
    const bool bar = ds < 0.0 || ds > 1.1 || dt < 0.0 || dt > 1.5 || std::abs(ds - 0.55) < 0.03;
    if (bar) return 215.0;
    const double tone = value_noise(column * 3.7 + 0.5, storey * 2.3 + 0.5, seed + 3);
    return 60.0 + 25.0 * tone + 35.0 * value_noise(s / 0.3, t / 0.5, seed + 4) +
           12.0 * value_noise(s / 0.04, t / 0.4, seed + 5);
  };
}

Paint wood(std::uint32_t seed) {
  return [=](double s, double t) {
    const double board = std::floor(s / 0.18);
    if (s - board * 0.18 < 0.006) return 60.0;
    const double tone = value_noise(board * 5.3 + 0.5, 0.5, seed);
    return 135.0 + 18.0 * tone + 30.0 * value_noise(s / 0.012, t / 0.25, seed + 1) +
           22.0 * value_noise(s / 0.05, t / 0.08, seed + 2);
  };
}

}  // namespace

std::vector<std::string> material_names() {
  return {"asphalt", "bricks",  "carton", "concrete", "facade",
          "plain",   "plaster", "poster", "tiles",    "wood"};
}

Paint material(const std::string& name, double width_m, double height_m, std::uint32_t seed) {
  if (name == "asphalt") return plaster(95.0, 55.0, seed);
  if (name == "bricks") return test_support::bricks(seed);
  if (name == "carton") return test_support::carton(width_m, height_m, seed);
  if (name == "concrete") return plaster(140.0, 45.0, seed);
  if (name == "facade") return facade(height_m, seed);
  if (name == "plain") return plaster(175.0, 5.0, seed);
  if (name == "poster") return test_support::poster(width_m, height_m, seed);
  if (name == "tiles") return test_support::floor_tiles(0.4, seed);
  if (name == "wood") return wood(seed);
  return plaster(155.0, 75.0, seed);
}

Paint cloth(double base, std::uint32_t seed) {
  return [=](double s, double t) {
    const double stripe = value_noise(std::floor(t / 0.035) * 1.7, 0.5, seed + 1);
    const double check = value_noise(std::floor(s / 0.05) * 1.3, 0.5, seed + 2);
    return base + 28.0 * stripe + 22.0 * check + 25.0 * value_noise(s / 0.02, t / 0.02, seed) +
           20.0 * value_noise(s / 0.15, t / 0.2, seed + 3);
  };
}

Paint face(double width_m, double height_m, std::uint32_t seed) {
  return [=](double s, double t) {
    const double skin = 175.0 + 10.0 * value_noise(s / 0.03, t / 0.03, seed);
    if (t < 0.28 * height_m) return 45.0 + 25.0 * value_noise(s / 0.01, t / 0.06, seed + 1);
    const double ds = std::abs(s - 0.5 * width_m) - 0.2 * width_m;
    if (std::hypot(ds, t - 0.45 * height_m) < 0.07 * width_m) return 35.0;
    if (std::abs(ds + 0.2 * width_m) < 0.17 * width_m && std::abs(t - 0.78 * height_m) < 0.012) {
      return 95.0;
    }
    return skin;
  };
}

Paint car_body(double width_m, double height_m, std::uint32_t seed) {
  const double base = 95.0 + 45.0 * value_noise(0.5, 0.5, seed);
  return [=](double s, double t) {
    const double sheen = 30.0 * (1.0 - t / height_m) +
                         22.0 * value_noise(s / 0.35, t / 0.25, seed + 1) +
                         14.0 * value_noise(s / 0.06, t / 0.06, seed + 2);
    const double door = std::fmod(s + 0.12 * width_m, 0.26 * width_m);
    if (door < 0.015 || t > 0.88 * height_m) return 30.0;
    const bool handle = door > 0.03 && door < 0.16 && std::abs(t - 0.22 * height_m) < 0.02;
    if (handle) return 225.0;
    const double end = std::min(s, width_m - s);
    const bool lamp = end < 0.22 && std::abs(t - 0.3 * height_m) < 0.09;
    if (lamp) return 235.0 - 60.0 * std::fmod(end, 0.08) / 0.08;
    return base + sheen;
  };
}

Paint car_cabin(double width_m, double height_m, std::uint32_t seed) {
  return [=](double s, double t) {
    const double edge = std::min({s, width_m - s, t});
    if (edge < 0.07 || std::abs(s - 0.5 * width_m) < 0.035) {
      return 120.0 + 40.0 * value_noise(s / 0.3, t / 0.3, seed);
    }
    return 52.0 + 35.0 * value_noise(s / 0.25, t / (0.3 * height_m), seed + 1) +
           14.0 * value_noise(s / 0.05, t / 0.05, seed + 2);
  };
}

}  // namespace egomod::sim
