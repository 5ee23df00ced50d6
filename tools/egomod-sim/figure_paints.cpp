// SPDX-License-Identifier: Apache-2.0
#include "figure_paints.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::sim {
namespace {

using test_support::Paint;
using test_support::value_noise;

double body_tone(std::uint32_t seed) { return 110.0 + 60.0 * value_noise(0.5, 0.5, seed); }

}  // namespace

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

// Sheen and dirt on one colour.
Paint car_paint(std::uint32_t seed) {
  const double tone = body_tone(seed);
  return [=](double s, double t) {
    return tone + 18.0 * value_noise(s / 0.35, t / 0.25, seed + 1) +
           12.0 * value_noise(s / 0.06, t / 0.06, seed + 2);
  };
}

Paint car_side(double length_m, double height_m, double wheel_radius_m, std::uint32_t seed) {
  const Paint paint = car_paint(seed);
  return [=](double s, double t) {
    const double z = s - 0.5 * length_m;
    const double arch = std::hypot(std::abs(z) - kAxle_m, t - height_m);
    if (arch < wheel_radius_m + 0.07) return 22.0;
    if (t > 0.86 * height_m) return 45.0;  // sill
    if (std::min(s, length_m - s) < 0.16 && std::abs(t - 0.3 * height_m) < 0.07) return 220.0;
    for (const double joint : {-0.95, -0.05, 0.85}) {
      const double ds = z - joint;
      if (std::abs(ds) < 0.008) return 35.0;
      if (ds > 0.08 && ds < 0.24 && std::abs(t - 0.2 * height_m) < 0.015) return 200.0;  // handle
    }
    const double crease = std::abs(t - 0.34 * height_m) < 0.012 ? -28.0 : 0.0;
    return paint(s, t) + 26.0 * (0.5 - t / height_m) + crease;
  };
}

Paint car_end(double width_m, double height_m, bool is_front, std::uint32_t seed) {
  const Paint paint = car_paint(seed);
  return [=](double s, double t) {
    const double x = std::abs(s - 0.5 * width_m);
    const double y = t / height_m;
    const bool is_plate = x < 0.26 && std::abs(y - 0.62) < 0.10;
    if (is_plate) {
      const bool is_letter = std::abs(y - 0.62) < 0.06 && std::fmod(s, 0.07) < 0.035;
      return is_letter && x < 0.22 ? 40.0 : 230.0;
    }
    if (x > 0.5 * width_m - 0.30 && std::abs(y - 0.30) < 0.14) {
      return is_front ? 232.0 - 40.0 * std::fmod(s, 0.06) / 0.06 : 150.0;  // lamps
    }
    if (is_front && x < 0.48 && std::abs(y - 0.32) < 0.11) {
      return std::fmod(y, 0.055) < 0.028 ? 40.0 : 110.0;  // grille
    }
    if (y > 0.74) return 52.0;  // bumper
    return paint(s, t) + 20.0 * (0.5 - y);
  };
}

// Glass that reflects the surroundings, in a frame of the car's colour.
Paint car_pane(double width_m, double height_m, int panes, std::uint32_t seed) {
  const Paint frame = car_paint(seed);
  return [=](double s, double t) {
    const double pitch = width_m / panes;
    const double across = std::fmod(s, pitch);
    const double edge = std::min({across, pitch - across, t, height_m - t});
    if (edge < 0.045) return frame(s, t);
    const double slant = s + 0.6 * t;
    return 60.0 + 38.0 * value_noise(slant / 0.35, t / 0.5, seed + 11) +
           14.0 * value_noise(s / 0.06, t / 0.06, seed + 12);
  };
}

}  // namespace egomod::sim
