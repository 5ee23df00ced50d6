// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "track_store.hpp"

namespace egomod {

// What the pair says of a point, with the covariance that residual and texture give it.
[[nodiscard]] StereoObservation observe(const FollowedPoint& point, const AffineTemplate& anchor);

// Smaller eigenvalue of the anchor's structure tensor without what noise adds to it.
[[nodiscard]] float texture(const FollowedPoint& point, const AffineTemplate& anchor);

}  // namespace egomod
