// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "optics.hpp"
#include "world.hpp"

namespace egomod::sim {

// One image of one camera.
struct Exposure {
  std::uint64_t number = 0;  // counts all, also those that get lost
  double t_s = 0.0;          // middle of the exposure of the middle row
  double late_s = 0.0;       // after its exposure it arrives
};

// Exposure `number` of a camera, whether or not it gets lost. Any order; the same world gives the
// same times.
[[nodiscard]] Exposure exposure(const World& world, Eye eye, std::uint64_t number);
[[nodiscard]] bool is_lost(const World& world, Eye eye, std::uint64_t number);
// The first left image that is not lost: its camera's pose is the origin of the truth.
[[nodiscard]] Exposure first_left_exposure(const World& world);
// What a camera delivers within the world's duration, in order of exposure.
[[nodiscard]] std::vector<Exposure> delivered(const World& world, Eye eye);

}  // namespace egomod::sim
