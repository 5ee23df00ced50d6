// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace egomod {

// Speeds are in m/s everywhere; people also read km/h.
inline constexpr double kKmhPerMps = 3.6;

}  // namespace egomod
