// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "driven_base.hpp"
#include "table_reader.hpp"

namespace egomod::sim {

// The table rig.driven of a world: where the base starts, what it can do, and what it is told, if
// that is not left to the bus. Throws WorldError.
[[nodiscard]] Drive read_drive(TableReader& in, const Floor& floor);

}  // namespace egomod::sim
