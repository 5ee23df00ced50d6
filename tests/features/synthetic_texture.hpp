// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "test_images.hpp"

namespace egomod::testing {

// A sum of plane waves, band-limited and known at every point: images of it under any warp are
// exact up to 8-bit rounding.
class WaveTexture {
 public:
  explicit WaveTexture(unsigned seed, double shortest_wave_px = 7.0, int waves = 60) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < waves; ++i) {
      const double frequency = 2.0 * M_PI / (shortest_wave_px * (1.0 + 2.0 * unit(random)));
      const double direction = 2.0 * M_PI * unit(random);
      waves_.push_back({frequency * std::cos(direction), frequency * std::sin(direction),
                        2.0 * M_PI * unit(random)});
    }
  }

  [[nodiscard]] double operator()(double x, double y) const {
    double total = 0.0;
    for (const Wave& w : waves_) total += std::sin(w.kx * x + w.ky * y + w.phase);
    return 128.0 + kContrast * total / std::sqrt(0.5 * static_cast<double>(waves_.size()));
  }

 private:
  static constexpr double kContrast = 32.0;  // standard deviation, grey levels
  struct Wave {
    double kx, ky, phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace egomod::testing
