// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "world.hpp"

namespace egomod::sim {

// What is wrong with the way that something takes through the world: when and where it leaves the
// floor or runs into furniture, an object or the rig. Nothing if it is fine. Held against what
// `world` holds so far.
[[nodiscard]] std::optional<std::string> fault_of_rig(const World& world);
[[nodiscard]] std::optional<std::string> fault_of_thing(const World& world, const Thing& thing);

}  // namespace egomod::sim
