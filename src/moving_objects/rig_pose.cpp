// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/rig_pose.hpp"

namespace egomod {
namespace {

void write(const Eigen::Matrix3d& M, double (&rows)[3][3]) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> to(&rows[0][0]);
  to = M;
}

void write_lower(const Eigen::Matrix3d& M, double (&lower)[6]) {
  for (Eigen::Index row = 0, at = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column <= row; ++column) lower[at++] = M(row, column);
}

}  // namespace

FilterStep filter_step(const RigPose& rig, const StereoCamera& camera) {
  FilterStep step{};
  step.fx_px = camera.fx_px;
  step.fy_px = camera.fy_px;
  step.cx_px = camera.cx_px;
  step.cy_px = camera.cy_px;
  step.fx_baseline_px_m = camera.fx_px * camera.baseline_m;
  write(rig.T_first_current.linear(), step.R_first_current);
  write(rig.T_current_first.linear(), step.R_current_first);
  Eigen::Vector3d::Map(&step.t_first_current_m[0]) = rig.T_first_current.translation();
  Eigen::Vector3d::Map(&step.t_current_first_m[0]) = rig.T_current_first.translation();
  write_lower(rig.translation_covariance, step.translation_covariance);
  write(rig.cross_covariance, step.cross_covariance);
  write(rig.rotation_covariance, step.rotation_covariance);
  return step;
}

}  // namespace egomod
