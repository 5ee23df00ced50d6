// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "egomod/egomotion/ransac.hpp"
#include "egomod/egomotion/robust_gauss_newton.hpp"
#include "egomod/egomotion/solution.hpp"

namespace egomod {

// The motion that most of the weight agrees on: graduated Gauss-Newton from the expected motion
// and, unless that one wins a majority, from no motion and from the best two minimal samples.
// Threads: one caller.
class GaussNewtonSolver {
 public:
  GaussNewtonSolver(const GaussNewtonConfig& config, const RansacConfig& ransac)
      : ransac_(ransac), gauss_newton_(config) {}

  void reserve(std::size_t points) { gauss_newton_.reserve(points); }

  // `sequence` seeds the sampling.
  [[nodiscard]] Solution solve(const StereoCamera& camera,
                               std::span<const Correspondence> correspondences,
                               const Eigen::Isometry3d& expected, std::uint64_t sequence);

  // The motion next to `start` that some of the weight agrees on, however much another one does.
  [[nodiscard]] Solution solve_near(const StereoCamera& camera,
                                    std::span<const Correspondence> correspondences,
                                    const Eigen::Isometry3d& start);

  // By how much the covariance of the last solution would be larger if neighbours erred together.
  [[nodiscard]] std::optional<double> common_error() { return gauss_newton_.common_error(last_); }

  // Squared Mahalanobis distances of the correspondences that were solved last.
  void measure_distances2(const Eigen::Isometry3d& T_current_previous,
                          std::vector<double>& distances2) const {
    gauss_newton_.measure_distances2(T_current_previous, distances2);
  }

 private:
  [[nodiscard]] Solution finished(const StereoCamera& camera,
                                  std::span<const Correspondence> correspondences,
                                  GaussNewtonResult best);
  void try_other_starts(const Eigen::Isometry3d& expected, std::uint64_t sequence,
                        GaussNewtonResult& best);

  RansacConfig ransac_;
  RobustGaussNewton gauss_newton_;
  GaussNewtonResult last_;
};

}  // namespace egomod
