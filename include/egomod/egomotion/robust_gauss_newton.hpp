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

struct GaussNewtonConfig {
  int max_iterations = 20;
  double step_tolerance = 1e-5;      // of the largest component of a step, m or rad
  double geman_mcclure_chi2 = 5.99;  // squared Mahalanobis distance at which a weight is a quarter
};

struct GaussNewtonResult {
  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  double cost = 0.0;      // robust, comparable between starts
  double scale = 1.0;     // robust scale of the squared distances, >= 1
  bool solvable = false;  // the normal equations had full rank in every iteration
};

// d(u, v, disparity) / dxi of the point P_m (current left frame) for
// T_previous_current * Exp(xi).
[[nodiscard]] Eigen::Matrix<double, 3, 6> motion_jacobian(const StereoCamera& camera,
                                                          const Eigen::Vector3d& P_m);

// Motion from stereo reprojection errors in (u, v, disparity), each whitened by the covariance of
// the current and of the previous observation, S = R + H C H^T; graduated Geman-McClure weights
// (A. Blake, A. Zisserman, Visual Reconstruction, 1987; M. Black, A. Rangarajan, IJCV 1996): the
// kernel starts wide and is halved each iteration, so that the start need not be near.
// Keeps its buffers between pairs. Threads: one caller.
class RobustGaussNewton {
 public:
  explicit RobustGaussNewton(const GaussNewtonConfig& config) : config_(config) {}

  // Room for that many points: nothing is allocated up to there.
  void reserve(std::size_t points) {
    points_.reserve(points);
    distances2_.reserve(points);
  }

  // Whitens all correspondences at this motion; call before all others, and again when the
  // motion has changed so much that the projected covariances have.
  void prepare(const StereoCamera& camera, std::span<const Correspondence> correspondences,
               const Eigen::Isometry3d& T_previous_current);

  // Least squares without robust weights on the sample, a few steps; false when it is singular.
  [[nodiscard]] bool fit_sample(std::span<const std::size_t> sample,
                                Eigen::Isometry3d& T_previous_current) const;

  // `graduation`: the kernel starts this many times as wide as it ends. Only every `stride`-th
  // point is used, to come near cheaply.
  [[nodiscard]] GaussNewtonResult refine(const Eigen::Isometry3d& start, double graduation,
                                         std::size_t stride);

  // Covariance (right perturbation) of a robust estimate: the sandwich A^-1 B A^-1 of
  // M-estimation (P. Huber, Robust Statistics, 1981, ch. 6), which carries the true scale of the
  // residuals with it; false when the points do not fix all six degrees of freedom.
  [[nodiscard]] bool covariance(const GaussNewtonResult& result, Matrix6d& covariance) const;

  // Squared Mahalanobis distance of one correspondence.
  [[nodiscard]] double distance2(const Eigen::Isometry3d& T_current_previous,
                                 std::size_t index) const;

  // Sum of weights of the points that this motion explains, soft; gives up below `abandon_below`.
  [[nodiscard]] double support(const Eigen::Isometry3d& T_previous_current,
                               double abandon_below) const;
  [[nodiscard]] double total_weight() const { return total_weight_; }

 private:
  struct Point {
    Eigen::Vector3d P_m;
    Eigen::Vector3d z_px;
    std::array<double, 6> whitening;  // lower triangle of L^-1, S = L L^T, row by row
    double weight;
  };
  struct Normal;

  // Returns the squared Mahalanobis distance.
  double accumulate(const Eigen::Isometry3d& T_current_previous, const Point& point, double kernel,
                    Normal& normal) const;
  [[nodiscard]] double residual_scale();  // of the distances of the last iteration
  [[nodiscard]] double robust_cost(const Eigen::Isometry3d& T_current_previous) const;

  GaussNewtonConfig config_;
  StereoCamera camera_;
  std::vector<Point> points_;
  std::vector<double> distances2_;
  double total_weight_ = 0.0;
};

}  // namespace egomod
