// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace egomod {

// Bilinear interpolation in fixed point. 1/64 px: products stay within signed 16 bits.
inline constexpr int kRectifyFractionBits = 6;
inline constexpr int kRectifyOne = 1 << kRectifyFractionBits;

// Of one rectified pixel: how far it lies to the right of and below its upper left neighbour, in
// 1/64 px (0..64).
struct RectifyFraction {
  std::uint8_t u = 0;
  std::uint8_t v = 0;
};

// Rectified pixels side by side whose neighbours lie in a window of 16 columns and 3 rows.
struct RectifyGroup {
  static constexpr int kPixels = 8;
  static constexpr int kColumns = 16;
  static constexpr int kRows = 3;

  std::int32_t offset = -1;                      // byte of the window's upper left; < 0: no group
  std::array<std::uint8_t, kPixels> column{};    // of the upper left neighbour in the window
  std::array<std::uint8_t, kPixels> is_lower{};  // 255 if it lies in the window's second row
};

// `upper`: the upper left one of the four neighbours.
[[nodiscard]] std::uint8_t rectified_pixel(const std::uint8_t* upper, std::ptrdiff_t stride,
                                           RectifyFraction fraction);

// The same for a whole group, bit by bit; `window` is its upper left, readable for 3 rows of 16.
void rectify_group(const std::uint8_t* window, std::ptrdiff_t stride, const RectifyGroup& group,
                   const RectifyFraction* fractions, std::uint8_t* to);

}  // namespace egomod
