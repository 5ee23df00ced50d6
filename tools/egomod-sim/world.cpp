// SPDX-License-Identifier: Apache-2.0
#include "world.hpp"

#include <array>
#include <cmath>

namespace egomod::sim {

int World::pairs() const { return static_cast<int>(std::ceil(duration_s * rate_hz - 1e-6)); }

Floor floor_of(const Shell& shell) {
  return {.x_min_m = -0.5 * shell.width_m,
          .x_max_m = 0.5 * shell.width_m,
          .z_min_m = -shell.rear_m,
          .z_max_m = shell.length_m - shell.rear_m};
}

std::string to_string(ThingKind kind) {
  constexpr std::array<const char*, 4> kNames{"box", "pioneer", "person", "car"};
  return kNames[static_cast<std::size_t>(kind)];
}

Eigen::Vector3d size_m(const Thing& thing) {
  switch (thing.kind) {
    case ThingKind::kPioneer:
      return {0.44, 0.75, 0.50};
    case ThingKind::kPerson:
      return {0.61, 1.73, 0.50};
    case ThingKind::kCar:
      return {1.76, 1.45, 4.20};
    case ThingKind::kBox:
      break;
  }
  return thing.size_m;
}

}  // namespace egomod::sim
