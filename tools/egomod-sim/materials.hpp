// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "texture.hpp"

namespace egomod::sim {

[[nodiscard]] std::vector<std::string> material_names();
// Paint for a surface of this size; the name is one of those above.
[[nodiscard]] test_support::Paint material(const std::string& name, double width_m, double height_m,
                                           std::uint32_t seed);

}  // namespace egomod::sim
