// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/gauss_newton_solver.hpp"

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
  gn.prepare(camera, correspondences, expected);
  GaussNewtonResult best =
      gn.refine(expected, kWideStart, stride_to_come_near(correspondences.size()));
  if (!best.solvable || gn.support(best.T_previous_current, 0.0) < kMajority * gn.total_weight())
    try_other_starts(correspondences, expected, sequence, best);
  if (best.solvable) {  // once more with the covariances projected where the points really are
    gn.prepare(camera, correspondences, best.T_previous_current);
    best = gn.refine(best.T_previous_current, 1.0, 1);
  }
  Solution solution{.T_previous_current = best.T_previous_current};
  if (!best.solvable || !gn.covariance(best, solution.covariance))
    solution.failure = EstimateReason::kDegenerate;
  return solution;
}

void GaussNewtonSolver::try_other_starts(std::span<const Correspondence> correspondences,
                                         const Eigen::Isometry3d& expected, std::uint64_t sequence,
                                         GaussNewtonResult& best) {
  const RobustGaussNewton& gn = gauss_newton_;
  const auto try_from = [&](const Eigen::Isometry3d& start) {
    const GaussNewtonResult other =
        gauss_newton_.refine(start, kCloseStart, stride_to_come_near(correspondences.size()));
    if (other.solvable && (!best.solvable || other.cost < best.cost)) best = other;
  };
  const auto voted = ransac(
      ransac_, sequence, correspondences.size(), gn.total_weight(),
      [&](const Sample& sample, Eigen::Isometry3d& T) {
        T = expected;
        return gn.fit_sample(sample, T);
      },
      [&](const Eigen::Isometry3d& T, double abandon) { return gn.support(T, abandon); });
  try_from(Eigen::Isometry3d::Identity());
  for (const Hypothesis& hypothesis : voted)
    if (hypothesis.support > 0) try_from(hypothesis.T_previous_current);
}

}  // namespace egomod
