// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/sigma_point_solver.hpp"

namespace egomod {
namespace {

// A sample of three is noisy, and so is the set that agrees with it: the final estimate collects
// its own set once more, else it would lean towards the sample.
constexpr int kConsensusRounds = 2;

Solution solution_of(const SigmaPointResult& result, double dt_s) {
  const Matrix6d J = motion_perturbation_of_velocity(result.posterior.y, dt_s);
  return {.T_previous_current = motion_of(result.posterior.y, dt_s),
          .covariance = J * result.covariance * J.transpose(),
          .failure = !result.observable  ? EstimateReason::kDegenerate
                     : !result.converged ? EstimateReason::kNotConverged
                                         : EstimateReason::kNone};
}

}  // namespace

bool SigmaPointSolver::agrees(const StereoCamera& camera,
                              const Eigen::Isometry3d& T_current_previous,
                              const Correspondence& c) const {
  return squared_reprojection_error(camera, T_current_previous, c) <
         ransac_.threshold_px * ransac_.threshold_px;
}

Solution SigmaPointSolver::solve(const StereoCamera& camera,
                                 std::span<const Correspondence> correspondences,
                                 const VelocityState& velocity, double dt_s, std::uint64_t sequence,
                                 std::size_t min_inliers) {
  const VelocityState prior = predicted(config_, velocity, dt_s);
  const Hypothesis voted = vote(camera, correspondences, prior, dt_s, sequence);
  Solution solution{.T_previous_current = voted.T_previous_current};
  for (int round = 0; round < kConsensusRounds; ++round) {
    collect_consensus(camera, correspondences, solution.T_previous_current.inverse());
    if (voted.support < 0 || consensus_.size() < min_inliers) {
      solution.failure = EstimateReason::kFewInliers;
      return solution;
    }
    filter_.prepare(camera, correspondences, solution.T_previous_current);
    const Vector6d start = velocity_of(solution.T_previous_current, dt_s);
    solution = solution_of(filter_.update(prior, start, dt_s, consensus_), dt_s);
    if (solution.failure != EstimateReason::kNone) return solution;
  }
  return solution;
}

Hypothesis SigmaPointSolver::vote(const StereoCamera& camera,
                                  std::span<const Correspondence> correspondences,
                                  const VelocityState& prior, double dt_s, std::uint64_t sequence) {
  filter_.prepare(camera, correspondences, motion_of(prior.y, dt_s));
  const auto count = static_cast<double>(correspondences.size());
  const auto voted = ransac(
      ransac_, sequence, correspondences.size(), count,
      [&](const Sample& sample, Eigen::Isometry3d& T) {
        const SigmaPointResult fitted = filter_.update(prior, prior.y, dt_s, sample);
        T = motion_of(fitted.posterior.y, dt_s);
        return fitted.observable;
      },
      [&](const Eigen::Isometry3d& T_previous_current, double abandon_below) {
        const Eigen::Isometry3d T = T_previous_current.inverse();
        double reachable = count;
        for (std::size_t k = 0; k < correspondences.size() && reachable > abandon_below; ++k)
          reachable -= agrees(camera, T, correspondences[k]) ? 0.0 : 1.0;
        return reachable;
      });
  return voted[0];
}

void SigmaPointSolver::collect_consensus(const StereoCamera& camera,
                                         std::span<const Correspondence> correspondences,
                                         const Eigen::Isometry3d& T_current_previous) {
  consensus_.clear();
  for (std::size_t k = 0; k < correspondences.size(); ++k)
    if (agrees(camera, T_current_previous, correspondences[k])) consensus_.push_back(k);
}

}  // namespace egomod
