// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/egomotion/ransac.hpp"
#include "egomod/egomotion/sigma_point_filter.hpp"
#include "egomod/egomotion/solution.hpp"

namespace egomod {

// The thesis's estimator: RANSAC whose samples are filtered from the predicted velocity, then the
// filter over the consensus set. Threads: one caller.
class SigmaPointSolver {
 public:
  SigmaPointSolver(const SigmaPointFilterConfig& config, const RansacConfig& ransac)
      : config_(config), ransac_(ransac), filter_(config) {}

  // `velocity`: of the last pair, `dt_s` ago. A consensus smaller than `min_inliers` is none.
  [[nodiscard]] Solution solve(const StereoCamera& camera,
                               std::span<const Correspondence> correspondences,
                               const VelocityState& velocity, double dt_s, std::uint64_t sequence,
                               std::size_t min_inliers);

  // Whether the motion brings the point within the threshold, pixels over both images.
  [[nodiscard]] bool agrees(const StereoCamera& camera, const Eigen::Isometry3d& T_current_previous,
                            const Correspondence& c) const;

 private:
  [[nodiscard]] Hypothesis vote(const StereoCamera& camera,
                                std::span<const Correspondence> correspondences,
                                const VelocityState& prior, double dt_s, std::uint64_t sequence);
  void collect_consensus(const StereoCamera& camera,
                         std::span<const Correspondence> correspondences,
                         const Eigen::Isometry3d& T_current_previous);

  SigmaPointFilterConfig config_;
  RansacConfig ransac_;
  SigmaPointFilter filter_;
  std::vector<std::size_t> consensus_;
};

}  // namespace egomod
