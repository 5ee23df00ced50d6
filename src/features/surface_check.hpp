// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skew.hpp"
#include "stereo_images.hpp"
#include "surroundings.hpp"

namespace egomod {

// A match that a search found is the best of those that show the patch unsheared. On a floor or
// along a wall, which the right image shows sheared, repeated texture elsewhere may look more alike
// than the place itself. So the surfaces that the neighbours lie on are tried as well. Gives the
// disparity that fits clearly better; not valid where two different ones fit alike, where what the
// right image shows belongs to another point's surface, or where the neighbours' surfaces lie
// outside of the right image, or are seen past, and none bears the match out.
[[nodiscard]] StereoMeasurement settle_by_neighbours(const StereoImages& images, const Skew& skew,
                                                     const Surroundings& surroundings,
                                                     const FollowedPoint& point);

// What the right image shows at the point's match is on the surface of what it shows around it, at
// another place of the left image: the right camera does not see the point.
[[nodiscard]] bool belongs_to_another(const StereoImages& images, const Surroundings& surroundings,
                                      const FollowedPoint& point);

}  // namespace egomod
