// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod {

// Rigid motions: xi = (rho, phi), translation first; T = Exp(xi) with the closed forms of
// T. D. Barfoot, State Estimation for Robotics (2017), eqs. 7.42, 7.85-7.86.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi_rad);
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);
// Exp(phi + delta) = Exp(J(phi) * delta) * Exp(phi) to first order; J(-phi) is the right Jacobian.
[[nodiscard]] Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi_rad);
[[nodiscard]] Eigen::Isometry3d se3_exp(const Vector6d& xi);
[[nodiscard]] Vector6d se3_log(const Eigen::Isometry3d& T);
// Ad(T): Exp(Ad(T) * xi) = T * Exp(xi) * T^-1.
[[nodiscard]] Matrix6d adjoint(const Eigen::Isometry3d& T);
// Rotation part projected back onto SO(3); call after each composition that is kept.
[[nodiscard]] Eigen::Isometry3d orthonormalised(const Eigen::Isometry3d& T);

// (u, v, disparity) of a point in the left camera frame; z must be > 0.
[[nodiscard]] Eigen::Vector3d project(const StereoCamera& camera, const Eigen::Vector3d& P_m);
// d(u, v, disparity) / dP, 3x3.
[[nodiscard]] Eigen::Matrix3d project_jacobian(const StereoCamera& camera,
                                               const Eigen::Vector3d& P_m);
// Point in the left camera frame of (u, v, disparity); disparity must be > 0 (thesis eqs. 21-22).
[[nodiscard]] Eigen::Vector3d triangulate(const StereoCamera& camera,
                                          const Eigen::Vector3d& uvd_px);
// dP / d(u, v, disparity), 3x3.
[[nodiscard]] Eigen::Matrix3d triangulate_jacobian(const StereoCamera& camera,
                                                   const Eigen::Vector3d& uvd_px);

// What a point's (u, v, disparity) are displaced by in px per second of readout, and an observation
// as it would be at the middle row's time.
[[nodiscard]] Eigen::Vector3d row_displacement_per_s(const StereoCamera& camera,
                                                     const Eigen::Vector3d& P_m,
                                                     const Vector6d& velocity);
[[nodiscard]] Eigen::Vector3d at_middle_row(const StereoCamera& camera,
                                            const Eigen::Vector3d& uvd_px, const RowTiming& rows);

[[nodiscard]] Eigen::Vector3d uvd(const StereoObservation& observation);
[[nodiscard]] Eigen::Matrix3d covariance(const StereoObservation& observation);

}  // namespace egomod
