// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

// Chooses the rectification of a raw rig of which K, distortion, sizes, R_right_left and
// t_right_left_m are given: sets both R_rectified_raw and `camera`, and images_are_raw.
// Both cameras turn half of their mutual rotation, then together by the smallest angle that lays
// the x axis along the baseline. The common focal length is the smallest at which every rectified
// pixel lies inside both raw images. Throws SourceError that begins with `where`.
void choose_rectification(Calibration& calibration, const std::string& where);

}  // namespace egomod
