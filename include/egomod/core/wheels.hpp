// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

namespace egomod {

// Where the wheels' odometry sees the body at a pair's exposure, in a frame of its own: the ground
// where the base began to count, x forward, y left, z up. It drifts, but not within some pairs.
struct WheelPose {
  Eigen::Isometry3d T_wheels_body = Eigen::Isometry3d::Identity();
  std::uint32_t stretch = 0;  // poses of different stretches have no frame in common
};

}  // namespace egomod
