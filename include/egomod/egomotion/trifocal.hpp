// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "egomod/core/calibration.hpp"

namespace egomod {

using CameraMatrix = Eigen::Matrix<double, 3, 4>;

// T[i](q, r): the tensor that relates three images A, B, C of a static scene.
using TrifocalTensor = std::array<Eigen::Matrix3d, 3>;

// The tensor of thesis eq. 9 for P_A = K [I 0]. Its determinants reduce to
// T_i = b_i c_4^T - b_4 c_i^T, with b, c the columns of P_B, P_C times diag(K^-1, 1) (R. Hartley,
// A. Zisserman, Multiple View Geometry, eq. 17.12), up to a common factor.
[[nodiscard]] TrifocalTensor trifocal_tensor(const Eigen::Matrix3d& K, const CameraMatrix& P_B,
                                             const CameraMatrix& P_C);

// Where the previous right/left match (u_right, v) / u_left lies in image C: x_C = x_i l_q T_i^qr,
// l the vertical line through u_left, as rectified epipolar lines run along the rows. Homogeneous;
// its last coordinate is depth in C times (u_right - u_left).
[[nodiscard]] Eigen::Vector3d transfer(const TrifocalTensor& tensor, double u_right_px, double v_px,
                                       double u_left_px);

// Camera matrices of the rig at two instants; the previous right camera is the world (thesis
// eqs. 10-13), and the tensors from the previous pair to the current left and right image
// (eqs. 14-15).
class StereoTransfer {
 public:
  StereoTransfer(const StereoCamera& camera, const Eigen::Isometry3d& T_current_previous);

  // (u_left, v_left, u_right, v_right) in the current pair of a match of the previous one (eqs.
  // 16-17); false when the point is not in front of the current cameras.
  [[nodiscard]] bool operator()(const Eigen::Vector3d& previous_uvd_px,
                                Eigen::Vector4d& current_px) const;

 private:
  TrifocalTensor to_left_;
  TrifocalTensor to_right_;
};

}  // namespace egomod
