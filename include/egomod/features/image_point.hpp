// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace egomod {

// A position in an image; pixel centres lie on integers.
struct ImagePoint {
  float u_px = 0.0F;
  float v_px = 0.0F;
};

[[nodiscard]] inline ImagePoint operator+(ImagePoint a, ImagePoint b) {
  return {a.u_px + b.u_px, a.v_px + b.v_px};
}
[[nodiscard]] inline ImagePoint operator-(ImagePoint a, ImagePoint b) {
  return {a.u_px - b.u_px, a.v_px - b.v_px};
}
[[nodiscard]] inline float length(ImagePoint p) {
  return std::sqrt(p.u_px * p.u_px + p.v_px * p.v_px);
}
[[nodiscard]] inline float distance(ImagePoint a, ImagePoint b) { return length(a - b); }

// A whole pixel.
struct PixelPosition {
  std::int32_t u_px = 0;
  std::int32_t v_px = 0;

  bool operator==(const PixelPosition&) const = default;
};

[[nodiscard]] inline PixelPosition nearest_pixel(ImagePoint point) {
  return {static_cast<std::int32_t>(std::lround(point.u_px)),
          static_cast<std::int32_t>(std::lround(point.v_px))};
}

}  // namespace egomod
