// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

// Whether matrices and sizes can be what they claim; false also for NaN.
[[nodiscard]] bool is_rotation(const Eigen::Matrix3d& R);
[[nodiscard]] bool is_rigid_transform(const Eigen::Matrix4d& T);
[[nodiscard]] bool is_camera_matrix(const Eigen::Matrix3d& K);  // [fx s cx; 0 fy cy; 0 0 1]
[[nodiscard]] bool is_image_size(double width_px, double height_px);

// What is wrong with a calibration, sizes included; empty if nothing is.
[[nodiscard]] std::string fault_of(const Calibration& calibration);

}  // namespace egomod
