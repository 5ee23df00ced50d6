// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace egomod {

// A position in an image; pixel centres lie on integers.
struct ImagePoint {
  float u_px = 0.0F;
  float v_px = 0.0F;
};

// A whole pixel.
struct PixelPosition {
  std::int32_t u_px = 0;
  std::int32_t v_px = 0;

  bool operator==(const PixelPosition&) const = default;
};

}  // namespace egomod
