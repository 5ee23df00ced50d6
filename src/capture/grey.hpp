// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace egomod {

// Luma of BT.601 in 8-bit fixed point; a grey triple stays what it is.
[[nodiscard]] constexpr std::uint8_t luma(int red, int green, int blue) {
  return static_cast<std::uint8_t>((77 * red + 150 * green + 29 * blue + 128) >> 8);
}

}  // namespace egomod
