// SPDX-License-Identifier: Apache-2.0
// The image kernels once more, as plain as their definitions: the oracle for the fast ones.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "egomod/core/image.hpp"

namespace egomod::testing {

inline int clamped_pixel(const ImageView& image, int u, int v) {
  return image.row(std::clamp(v, 0, image.height_px - 1))[std::clamp(u, 0, image.width_px - 1)];
}

inline int reference_half_pixel(const ImageView& fine, int u, int v) {
  constexpr std::array<int, 4> weight{1, 3, 3, 1};
  int total = 0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      total += weight[static_cast<std::size_t>(i)] * weight[static_cast<std::size_t>(j)] *
               clamped_pixel(fine, 2 * u - 1 + i, 2 * v - 1 + j);
  return (total + 32) / 64;
}

struct SegmentTest {
  int contrast = 0;
  bool bright = false;
};

inline SegmentTest reference_segment_test(const ImageView& image, int u, int v, int threshold) {
  constexpr int du[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int dv[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  const int centre = image.row(v)[u];
  int darker = 0, brighter = 0;
  for (int start = 0; start < 16; ++start) {
    int above = 255, below = 255;
    for (int k = start; k < start + 9; ++k) {
      const int p = image.row(v + dv[k & 15])[u + du[k & 15]];
      above = std::min(above, p - centre);
      below = std::min(below, centre - p);
    }
    darker = std::max(darker, above);
    brighter = std::max(brighter, below);
  }
  const int contrast = std::max(darker, brighter);
  return {contrast > threshold ? contrast : 0, brighter > darker};
}

struct ReferenceSums {
  int xx = 0, xy = 0, yy = 0, noise = 0;
};

inline ReferenceSums reference_window_sums(const ImageView& image, int u, int v) {
  ReferenceSums s;
  for (int y = v - 3; y <= v + 3; ++y) {
    for (int x = u - 3; x <= u + 3; ++x) {
      const auto p = [&](int i, int j) -> int { return image.row(y + j)[x + i]; };
      const int gx = p(1, -1) + 2 * p(1, 0) + p(1, 1) - p(-1, -1) - 2 * p(-1, 0) - p(-1, 1);
      const int gy = p(-1, 1) + 2 * p(0, 1) + p(1, 1) - p(-1, -1) - 2 * p(0, -1) - p(1, -1);
      const int n = p(-1, -1) - 2 * p(0, -1) + p(1, -1) - 2 * p(-1, 0) + 4 * p(0, 0) - 2 * p(1, 0) +
                    p(-1, 1) - 2 * p(0, 1) + p(1, 1);
      s.xx += gx * gx;
      s.xy += gx * gy;
      s.yy += gy * gy;
      s.noise += n * n;
    }
  }
  return s;
}

// Zero-mean NCC of two squares; -1 where the second is flat.
inline double reference_ncc(const ImageView& a, int ua, int va, const ImageView& b, int ub, int vb,
                            int side) {
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double x = a.row(va + j)[ua + i], y = b.row(vb + j)[ub + i];
      sa += x;
      sb += y;
      saa += x * x;
      sbb += y * y;
      sab += x * y;
    }
  }
  const double n = side * side;
  const double flat = n * n / 2;
  if (n * saa - sa * sa < flat || n * sbb - sb * sb < flat) return -1.0;
  return (n * sab - sa * sb) / std::sqrt((n * saa - sa * sa) * (n * sbb - sb * sb));
}

}  // namespace egomod::testing
