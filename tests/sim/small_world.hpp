// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "world.hpp"

namespace egomod::sim::test {

// The world of this text, as if it were a file. Throws WorldError.
[[nodiscard]] World world_of(const std::string& text);

// A small room with a small camera, quick to paint and to render: the rig drives and turns, a robot
// crosses, a box turns on the spot.
[[nodiscard]] std::string small_room();
// The same with every knob of realism on.
[[nodiscard]] std::string unreal_room();

}  // namespace egomod::sim::test
