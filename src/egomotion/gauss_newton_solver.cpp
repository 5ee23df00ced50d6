// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/gauss_newton_solver.hpp"

#include <limits>

namespace egomod {
namespace {

constexpr double kWideStart = 64.0;  // graduation from a predicted motion
constexpr double kCloseStart = 2.0;  // ... from one that points voted for
constexpr std::size_t kPointsToComeNear = 300;
constexpr double kMajority = 0.5;  // no other motion can explain as many points

std::size_t stride_to_come_near(std::size_t points) { return 1 + points / kPointsToComeNear; }

}  // namespace

Solution GaussNewtonSolver::solve(const StereoCamera& camera,
                                  std::span<const Correspondence> correspondences,
                                  const Eigen::Isometry3d& expected, std::uint64_t sequence) {
  RobustGaussNewton& gn = gauss_newton_;
  gn.prepare(camera, correspondences, expected, stride_to_come_near(correspondences.size()));
  GaussNewtonResult best = gn.refine(expected, kWideStart);
  if (!best.solvable || gn.support(best.T_previous_current) < kMajority * gn.total_weight())
    try_other_starts(expected, sequence, best);
  return finished(camera, correspondences, best);
}

Solution GaussNewtonSolver::solve_near(const StereoCamera& camera,
                                       std::span<const Correspondence> correspondences,
                                       const Eigen::Isometry3d& start) {
  gauss_newton_.prepare(camera, correspondences, start,
                        stride_to_come_near(correspondences.size()));
  return finished(camera, correspondences, gauss_newton_.refine(start, 1.0));
}

Solution GaussNewtonSolver::finished(const StereoCamera& camera,
                                     std::span<const Correspondence> correspondences,
                                     GaussNewtonResult best) {
  RobustGaussNewton& gn = gauss_newton_;
  if (best.solvable) {  // once more, with all, their covariances projected where they really are
    gn.prepare(camera, correspondences, best.T_previous_current);
    best = gn.refine(best.T_previous_current, 1.0);
  }
  last_ = best;
  Solution solution{.T_previous_current = best.T_previous_current};
  if (!best.solvable || !gn.covariance(best, solution.covariance))
    solution.failure = EstimateReason::kDegenerate;
  return solution;
}

void GaussNewtonSolver::try_other_starts(const Eigen::Isometry3d& expected, std::uint64_t sequence,
                                         GaussNewtonResult& best) {
  RobustGaussNewton& gn = gauss_newton_;
  double best_cost =
      best.solvable ? gn.cost(best.T_previous_current) : std::numeric_limits<double>::infinity();
  const auto try_from = [&](const Eigen::Isometry3d& start) {
    const GaussNewtonResult other = gn.refine(start, kCloseStart);
    if (!other.solvable) return;
    const double cost = gn.cost(other.T_previous_current);
    if (cost >= best_cost) return;
    best = other;
    best_cost = cost;
  };
  const auto voted = ransac(
      ransac_, sequence, gn.size(), gn.total_weight(),
      [&](const Sample& sample, Eigen::Isometry3d& T) {
        T = expected;
        return gn.fit_sample(sample, T);
      },
      [&](const Eigen::Isometry3d& T, double) { return gn.support(T); });
  try_from(Eigen::Isometry3d::Identity());
  for (const Hypothesis& hypothesis : voted)
    if (hypothesis.support > 0) try_from(hypothesis.T_previous_current);
}

}  // namespace egomod
