// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "texture.hpp"

namespace egomod::sim {

inline constexpr double kAxle_m = 1.30;  // from the middle of a car, before and behind

// What people and cars are painted with.
[[nodiscard]] test_support::Paint cloth(double base, std::uint32_t seed);
[[nodiscard]] test_support::Paint face(double width_m, double height_m, std::uint32_t seed);
[[nodiscard]] test_support::Paint car_paint(std::uint32_t seed);
[[nodiscard]] test_support::Paint car_side(double length_m, double height_m, double wheel_radius_m,
                                           std::uint32_t seed);
[[nodiscard]] test_support::Paint car_end(double width_m, double height_m, bool is_front,
                                          std::uint32_t seed);
[[nodiscard]] test_support::Paint car_pane(double width_m, double height_m, int panes,
                                           std::uint32_t seed);

}  // namespace egomod::sim
