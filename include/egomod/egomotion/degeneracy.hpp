// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "egomod/core/egomotion.hpp"
#include "egomod/egomotion/correspondence.hpp"

namespace egomod {

// Whether the inliers fill no more than a line, within their noise. Noise gives points on a line a
// thickness, which lets them feign that they fix the rotation about it. Lines in space are lines in
// (u, v, disparity), where noise is even. `roles` is indexed by Correspondence::track.
[[nodiscard]] bool inliers_lie_on_a_line(std::span<const Correspondence> correspondences,
                                         std::span<const TrackRole> roles);

}  // namespace egomod
