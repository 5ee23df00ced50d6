// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/core/calibration.hpp"

namespace egomod {

inline const StereoCamera kCamera{.fx_px = 500.0,
                                  .fy_px = 500.0,
                                  .cx_px = 320.0,
                                  .cy_px = 240.0,
                                  .baseline_m = 0.3,
                                  .width_px = 640,
                                  .height_px = 480};

}  // namespace egomod
