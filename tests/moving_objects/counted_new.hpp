// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace egomod {

// How often this program has called operator new.
[[nodiscard]] long allocations();

}  // namespace egomod
