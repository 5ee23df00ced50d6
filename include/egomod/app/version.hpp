// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod {

// Version, sources and options that are built in; a line each.
[[nodiscard]] std::string version_text();

}  // namespace egomod
