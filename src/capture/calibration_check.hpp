// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

// Whether matrices and sizes can be what they claim; false also for NaN.
[[nodiscard]] bool is_rotation(const Eigen::Matrix3d& R);
[[nodiscard]] bool is_rigid_transform(const Eigen::Matrix4d& T);
[[nodiscard]] bool is_camera_matrix(const Eigen::Matrix3d& K);  // [fx s cx; 0 fy cy; 0 0 1]
[[nodiscard]] bool is_image_size(double width_px, double height_px);
[[nodiscard]] bool is_baseline(double baseline_m);
[[nodiscard]] bool is_distortion(std::span<const double> coefficients);
// Of one axis; `side_px`: the image's along it, 0 if it is not known yet.
[[nodiscard]] bool is_focal_length(double f_px, int side_px);
[[nodiscard]] bool is_principal_point(double c_px, int side_px);

// What they ask for, to follow the name of a value in a message.
inline constexpr char kBaselineRule[] = "must be positive and at most 100 m";
inline constexpr char kDistortionRule[] = "must be coefficients of at most 1000";
inline constexpr char kFocalLengthRule[] =
    "must be positive and at most 1000 times the image's side";
inline constexpr char kPrincipalPointRule[] = "must lie within 10 image sizes of the image";

// What is wrong with a calibration, sizes included; empty if nothing is.
[[nodiscard]] std::string fault_of(const Calibration& calibration);

}  // namespace egomod
