// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace egomod {

// Of an array in a message.
template <std::size_t N>
[[nodiscard]] bool all_finite(const double (&values)[N]) {
  return std::all_of(std::begin(values), std::end(values),
                     [](double x) { return std::isfinite(x); });
}

}  // namespace egomod
