// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <egomod/core/geometry.hpp>
#include <egomod/pose_t.hpp>

int main() {
  const egomod::StereoCamera camera{.fx_px = 500.0,
                                    .fy_px = 500.0,
                                    .cx_px = 320.0,
                                    .cy_px = 240.0,
                                    .baseline_m = 0.2,
                                    .width_px = 640,
                                    .height_px = 480};
  const double disparity_px = egomod::project(camera, {0.0, 0.0, 2.0})[2];
  std::printf("disparity %.1f px, pose_t hash %llx\n", disparity_px,
              static_cast<unsigned long long>(egomod::pose_t::getHash()));
  return std::abs(disparity_px - 50.0) < 1e-9 ? 0 : 1;
}
