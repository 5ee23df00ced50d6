// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/egomotion/correspondence.hpp"

namespace egomod {

struct SigmaPointFilterConfig {
  int max_iterations = 8;
  double step_tolerance = 1e-2;  // of a step, in posterior standard deviations
  double initial_speed_sigma_mps = 15.0;
  double initial_turn_sigma_radps = 1.5;
  double acceleration_sigma_mps2 = 10.0;  // process noise of the constant velocity
  double turn_acceleration_sigma_radps2 = 10.0;
};

inline constexpr std::size_t kSigmaPoints = 12;

// Symmetric sigma points mean +- sqrt(6) L e_j, covariance = L L^T, all of weight 1/12: mean and
// covariance are reproduced exactly (S. Julier, J. Uhlmann, Proc. IEEE 2004, with kappa = 0).
[[nodiscard]] std::array<Vector6d, kSigmaPoints> sigma_points(const Vector6d& mean,
                                                              const Matrix6d& cholesky);

// The state y = (V, omega), previous left camera axes, m/s and rad/s (thesis eq. 18).
struct VelocityState {
  Vector6d y = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Identity();
};

// The motion that the velocity makes in dt: translation V dt, rotation Exp(omega dt).
[[nodiscard]] Eigen::Isometry3d motion_of(const Vector6d& y, double dt_s);
[[nodiscard]] Vector6d velocity_of(const Eigen::Isometry3d& T_previous_current, double dt_s);
// d(right perturbation of the motion) / dy.
[[nodiscard]] Matrix6d motion_perturbation_of_velocity(const Vector6d& y, double dt_s);

// Constant velocity (thesis eq. 19): the state after dt.
[[nodiscard]] VelocityState predicted(const SigmaPointFilterConfig& config,
                                      const VelocityState& state, double dt_s);

struct SigmaPointResult {
  VelocityState posterior;  // as the filter believes, with its diagonal R
  // Of the same estimate, with the correlation that left and right image really have.
  Matrix6d covariance = Matrix6d::Zero();
  bool converged = false;
  bool observable = false;  // the measurements alone, without the prior, fix all six
};

// Iterated sigma-point Kalman filter (G. Sibley, G. Sukhatme, L. Matthies, RSS 2006) over
// y = (V, omega). 4N measurements: the trifocal transfer of each previous match into both current
// images (thesis eqs. 16-17), R diagonal, holding the variances of both observations. Each
// iteration linearises statistically about the last posterior; in information form it costs one
// 6x6 solve however many points there are. Threads: one caller.
class SigmaPointFilter {
 public:
  explicit SigmaPointFilter(const SigmaPointFilterConfig& config) : config_(config) {}

  // Keeps what an update needs of each correspondence.
  void prepare(const StereoCamera& camera, std::span<const Correspondence> correspondences,
               const Eigen::Isometry3d& T_previous_current);

  // `start`: where to linearise first.
  [[nodiscard]] SigmaPointResult update(const VelocityState& prior, const Vector6d& start,
                                        double dt_s, std::span<const std::size_t> used) const;

 private:
  struct Point {
    Eigen::Vector3d previous_px;  // u, v, disparity
    Eigen::Vector4d z_px;         // u, v left; u, v right
    Eigen::Vector4d variance_px2;
    Eigen::Matrix4d covariance_px2;
  };
  struct Linearised;

  [[nodiscard]] Linearised linearise(const Vector6d& mean, const Matrix6d& cholesky, double dt_s,
                                     std::span<const std::size_t> used) const;

  SigmaPointFilterConfig config_;
  StereoCamera camera_;
  std::vector<Point> points_;
};

}  // namespace egomod
