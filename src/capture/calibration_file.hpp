// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "egomod/core/calibration.hpp"

namespace egomod {

using Matrix34d = Eigen::Matrix<double, 3, 4>;

// The one camera behind two rectified projection matrices. Throws SourceError, beginning with
// `where`, if they are not a rectified pair. The image size stays 0.
[[nodiscard]] StereoCamera rectified_camera(const Matrix34d& P_left, const Matrix34d& P_right,
                                            const std::string& where);

// P0 and P1 of calib.txt of KITTI odometry; it holds no image size.
[[nodiscard]] Calibration read_kitti_calibration(const std::filesystem::path& file);

// Raw cameras 00 and 01 and their rectification, named as in calib_cam_to_cam.txt of KITTI raw.
[[nodiscard]] Calibration read_kitti_raw_calibration(const std::filesystem::path& file);

}  // namespace egomod
