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

// Painted plaster above a skirting board, with a door where there is room for one.
Paint wall(double width_m, double height_m, std::uint32_t seed) {
  const Paint paint = plaster(160.0, 62.0, seed);
  const bool has_door = width_m > 3.0 && height_m > 2.3;
  constexpr double kDoor_m = 1.1;
  return [=](double s, double t) {
    const double up = height_m - t;
    const double across = s - kDoor_m;
    const bool is_frame = up < 2.12 && across > -0.57 && across < 0.57;
    if (has_door && is_frame) {
      const bool is_leaf = up < 2.05 && across > -0.5 && across < 0.5;
      if (!is_leaf) return 205.0;
      const bool is_panel = std::abs(across) < 0.36 && std::fmod(up, 0.98) > 0.16;
      if (std::hypot(across - 0.42, up - 1.03) < 0.035) return 225.0;
      return (is_panel ? 118.0 : 98.0) + 26.0 * value_noise(s / 0.02, t / 0.3, seed + 6);
    }
    if (up < 0.09)
      return up > 0.08 ? 60.0 : 100.0 + 15.0 * value_noise(s / 0.1, t / 0.02, seed + 7);
    return paint(s, t);
  };
}

// Mineral fibre boards in a grid, some of them lamps, each of its own brightness.
Paint boards(std::uint32_t seed) {
  constexpr double kBoard_m = 0.6;
  return [=](double s, double t) {
    const double i = std::floor(s / kBoard_m);
    const double j = std::floor(t / kBoard_m);
    const double ds = s - i * kBoard_m;
    const double dt = t - j * kBoard_m;
    if (ds < 0.024 || dt < 0.024) return 120.0;
    // Not in rows: a pattern that repeats is taken for itself one period further.
    const double chance = value_noise(i * 7.3 + 0.5, j * 5.9 + 0.5, seed + 3);
    if (chance > 0.55) {
      return 195.0 + 70.0 * chance - 20.0 * (std::fmod(ds, 0.1) < 0.012 ? 1.0 : 0.0);
    }
    const double hole = value_noise(s / 0.02, t / 0.02, seed + 1);
    return 172.0 + 8.0 * value_noise(i * 3.1 + 0.5, j * 2.7 + 0.5, seed) +
           14.0 * value_noise(s / 0.15, t / 0.15, seed + 2) - (hole > 0.45 ? 55.0 : 0.0);
  };
}

// Rows of books; each has its width, height and colour, and a label on its back.
Paint shelf(double width_m, double height_m, std::uint32_t seed) {
  constexpr double kRow_m = 0.32;
  constexpr double kBook_m = 0.045;
  return [=](double s, double t) {
    const double row = std::floor(t / kRow_m);
    const double dt = t - row * kRow_m;
    const bool is_board = dt < 0.025 || std::min(s, width_m - s) < 0.025 || height_m - t < 0.06;
    if (is_board) return 128.0 + 25.0 * value_noise(s / 0.3, t / 0.012, seed);
    const double wander = 0.35 * value_noise(s / 0.11, row + 0.5, seed + 1);
    const double book = std::floor(s / kBook_m + wander);
    const double tone = value_noise(book * 1.7 + 0.5, row * 2.3 + 0.5, seed + 2);
    const double top = 0.07 + 0.06 * (1.0 + value_noise(book * 2.9 + 0.5, row + 0.5, seed + 3));
    if (dt < top) return 32.0;
    const double edge = s / kBook_m + wander - book;
    if (edge < 0.10) return 45.0;
    const bool is_label = std::abs(dt - top - 0.06) < 0.012 && edge > 0.25 && edge < 0.85;
    return is_label ? 215.0
                    : 122.0 + 85.0 * tone + 12.0 * value_noise(s / 0.01, t / 0.05, seed + 4);
  };
}

// Asphalt between pavements of slabs, a broken line along its middle.
Paint road(double width_m, std::uint32_t seed) {
  const Paint asphalt = plaster(92.0, 55.0, seed);
  const Paint slabs = test_support::floor_tiles(0.5, seed + 3);
  constexpr double kPavement_m = 2.0;
  const bool has_pavement = width_m > 8.0;
  return [=](double s, double t) {
    const double from_edge = std::min(s, width_m - s);
    if (has_pavement && from_edge < kPavement_m) return slabs(s, t) + 30.0;
    if (has_pavement && from_edge < kPavement_m + 0.15) return 185.0;  // kerb
    const bool is_line = std::abs(s - 0.5 * width_m) < 0.07 && std::fmod(t, 6.0) < 3.0;
    return is_line ? 205.0 + 20.0 * value_noise(s / 0.04, t / 0.04, seed + 9) : asphalt(s, t);
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
  return {"asphalt", "boards", "bricks", "carton", "concrete", "facade",    "plain", "plaster",
          "poster",  "road",   "shelf",  "tiles",  "wall",     "whitewash", "wood"};
}

Paint material(const std::string& name, double width_m, double height_m, std::uint32_t seed) {
  if (name == "asphalt") return plaster(95.0, 55.0, seed);
  if (name == "boards") return boards(seed);
  if (name == "bricks") return test_support::bricks(seed);
  if (name == "carton") return test_support::carton(width_m, height_m, seed);
  if (name == "concrete") return plaster(140.0, 45.0, seed);
  if (name == "facade") return facade(height_m, seed);
  if (name == "plain") return plaster(175.0, 5.0, seed);
  if (name == "poster") return test_support::poster(width_m, height_m, seed);
  if (name == "road") return road(width_m, seed);
  if (name == "shelf") return shelf(width_m, height_m, seed);
  if (name == "tiles") return test_support::floor_tiles(0.4, seed);
  if (name == "wall") return wall(width_m, height_m, seed);
  if (name == "whitewash") return plaster(188.0, 38.0, seed);
  if (name == "wood") return wood(seed);
  return plaster(155.0, 75.0, seed);
}

}  // namespace egomod::sim
