// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
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
  void reserve(std::size_t points);

  // Whitens the correspondences, or every `stride`-th of them to come near cheaply, at this motion;
  // call before all others, and again when the motion has changed so much that the projected
  // covariances have.
  void prepare(const StereoCamera& camera, std::span<const Correspondence> correspondences,
               const Eigen::Isometry3d& T_previous_current, std::size_t stride = 1);
  [[nodiscard]] std::size_t size() const { return size_; }

  // Least squares without robust weights on the sample, a few steps; false when it is singular.
  [[nodiscard]] bool fit_sample(std::span<const std::size_t> sample,
                                Eigen::Isometry3d& T_previous_current) const;

  // `graduation`: the kernel starts this many times as wide as it ends.
  [[nodiscard]] GaussNewtonResult refine(const Eigen::Isometry3d& start, double graduation);

  // Covariance (right perturbation) of a robust estimate: the sandwich A^-1 B A^-1 of
  // M-estimation (P. Huber, Robust Statistics, 1981, ch. 6), which carries the true scale of the
  // residuals with it; false when the points do not fix all six degrees of freedom.
  [[nodiscard]] bool covariance(const GaussNewtonResult& result, Matrix6d& covariance);

  // By how much the covariance found last would be larger if points that are near each other, in
  // the image and in depth, erred together: the trace of the cluster-robust sandwich (K.-Y. Liang,
  // S. Zeger, Biometrika 73, 1986) by that of the plain one, on average 1 where all err on their
  // own. One pair tells it roughly. Nothing where the points fill too few cells.
  [[nodiscard]] std::optional<double> common_error(const GaussNewtonResult& result);

  // Squared Mahalanobis distances of all points; resizes `distances2`.
  void measure_distances2(const Eigen::Isometry3d& T_current_previous,
                          std::vector<double>& distances2) const;

  // Sum of weights of the points that this motion explains, soft.
  [[nodiscard]] double support(const Eigen::Isometry3d& T_previous_current);
  // Robust sum of squares, comparable between motions.
  [[nodiscard]] double cost(const Eigen::Isometry3d& T_previous_current);
  [[nodiscard]] double total_weight() const { return total_weight_; }

 private:
  // Of one point: x y z, u v d, lower triangle of L^-1 row by row (S = L L^T), weight.
  static constexpr std::size_t kColumns = 13;

  void add(const Correspondence& c, const Eigen::Isometry3d& T_current_previous);
  void fill_up();
  // Cells of the image, each once near and once far: a systematic error of the images, or of the
  // map, is about the same in one.
  static constexpr std::size_t kCellColumns = 4;
  static constexpr std::size_t kCellRows = 3;
  static constexpr std::size_t kCells = 2 * kCellColumns * kCellRows;
  [[nodiscard]] std::size_t cell_of(std::size_t i, double median_disparity_px) const;
  void sort_into_cells();
  [[nodiscard]] double residual_scale();  // of the last distances
  [[nodiscard]] double robust_sum(const Eigen::Isometry3d& T_previous_current, double kernel);

  GaussNewtonConfig config_;
  StereoCamera camera_;
  std::size_t size_ = 0;
  std::array<std::vector<double>, kColumns> columns_;  // filled up to whole vectors
  std::vector<double> distances2_;
  std::vector<double> scratch_;
  double total_weight_ = 0.0;
  Matrix6d noise_ = Matrix6d::Zero();  // of the normal equations' right side, by the covariance
  std::array<std::vector<double>, kColumns> by_cell_;  // the columns, a cell filled up each
  std::array<std::size_t, kCells + 1> cell_begins_{};
  std::vector<std::size_t> cells_;  // of the points
};

}  // namespace egomod
