// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/features/corners.hpp"
#include "egomod/features/pyramid.hpp"

namespace egomod {

// Mean gradients of 4x4 cells around a corner, normalised: brightness and contrast don't matter.
// Two sizes of window, 4:3, so that two views whose scale differs by up to about 1.4 still agree in
// one of the combinations.
struct Descriptor {
  static constexpr int kBytes = 32;
  alignas(32) std::array<std::uint8_t, kBytes> narrow{};
  alignas(32) std::array<std::uint8_t, kBytes> wide{};
};

// Describes the surroundings (25 and 33 px at full resolution) of a full-resolution position; false
// where they leave the image or are flat. Needs a pyramid of two levels.
[[nodiscard]] bool describe(const Pyramid& pyramid, ImagePoint position, Descriptor& descriptor);

}  // namespace egomod
