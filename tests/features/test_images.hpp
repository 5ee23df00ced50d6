// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "egomod/core/image.hpp"

namespace egomod::testing {

template <class Grey>
Image painted(int width_px, int height_px, Grey grey) {
  Image image(width_px, height_px);
  for (int v = 0; v < height_px; ++v)
    for (int u = 0; u < width_px; ++u)
      image.row(v)[u] = static_cast<std::uint8_t>(
          std::lround(std::clamp(static_cast<double>(grey(u, v)), 0.0, 255.0)));
  return image;
}

inline Image flat_image(int width_px, int height_px, double grey, double noise_sigma,
                        unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  return painted(width_px, height_px, [&](int, int) { return grey + noise_sigma * noise(random); });
}

// Gaussian spots scattered at random over a background: unique everywhere, like a poster.
class SpottedTexture {
 public:
  SpottedTexture(double width_px, double height_px, unsigned seed, double contrast = 60.0,
                 double spacing_px = 9.0)
      : cell_px_(spacing_px), columns_(static_cast<int>(width_px / spacing_px) + 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const int rows = static_cast<int>(height_px / spacing_px) + 1;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns_; ++c)
        spots_.push_back({(c + unit(random)) * spacing_px, (r + unit(random)) * spacing_px,
                          1.4 + 1.6 * unit(random), contrast * (2.0 * unit(random) - 1.0)});
  }

  [[nodiscard]] double operator()(double x, double y) const {
    const int rows = static_cast<int>(spots_.size()) / columns_;
    const int c = static_cast<int>(std::floor(x / cell_px_));
    const int r = static_cast<int>(std::floor(y / cell_px_));
    double grey = 120.0;
    for (int j = std::max(r - 2, 0); j <= std::min(r + 2, rows - 1); ++j)
      for (int i = std::max(c - 2, 0); i <= std::min(c + 2, columns_ - 1); ++i)
        grey += value(spots_[static_cast<std::size_t>(j * columns_ + i)], x, y);
    return grey;
  }

 private:
  struct Spot {
    double x, y, sigma, contrast;
  };
  static double value(const Spot& s, double x, double y) {
    const double dx = (x - s.x) / s.sigma, dy = (y - s.y) / s.sigma;
    return s.contrast * std::exp(-0.5 * (dx * dx + dy * dy));
  }

  double cell_px_;
  int columns_;
  std::vector<Spot> spots_;
};

}  // namespace egomod::testing
