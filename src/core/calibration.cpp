// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/calibration.hpp"

namespace egomod {

Eigen::Isometry3d default_T_body_camera() {
  Eigen::Isometry3d T_body_camera = Eigen::Isometry3d::Identity();
  T_body_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T_body_camera;
}

bool operator==(const Calibration& a, const Calibration& b) {
  return a.camera == b.camera && a.images_are_raw == b.images_are_raw && a.left == b.left &&
         a.right == b.right && a.R_right_left == b.R_right_left &&
         a.t_right_left_m == b.t_right_left_m &&
         a.T_body_camera.matrix() == b.T_body_camera.matrix();
}

}  // namespace egomod
