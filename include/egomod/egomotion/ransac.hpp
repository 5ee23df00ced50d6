// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>

namespace egomod {

struct RansacConfig {
  int max_samples = 100;
  double threshold_px = 2.0;  // Euclidean, over both images
  double confidence = 0.995;  // of at least one sample without outliers
  std::uint32_t seed = 1;
};

inline constexpr std::size_t kSampleSize = 3;  // three points fix a rigid motion
using Sample = std::array<std::size_t, kSampleSize>;

// Draws uniformly without repetition; the same seed gives the same samples.
class Sampler {
 public:
  Sampler(std::uint32_t seed, std::uint64_t sequence)
      : generator_(static_cast<std::uint32_t>(seed + 7919U * sequence + 1U)) {}

  [[nodiscard]] Sample draw(std::size_t count);

 private:
  std::minstd_rand generator_;
};

// Samples that give `confidence` when a share of the points agrees (M. Fischler, R. Bolles, 1981).
[[nodiscard]] int samples_needed(double inlier_share, double confidence, int max_samples);

struct Hypothesis {
  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  double support = -1.0;
};

// The two hypotheses of most support, best first. `fit(sample, T)` returns whether the sample fixes
// a motion; `support(T, abandon_below)` may give up once it cannot reach `abandon_below`. Ends
// early, as soon as enough samples were drawn for the share of points that agree.
template <typename Fit, typename Support>
[[nodiscard]] std::array<Hypothesis, 2> ransac(const RansacConfig& config, std::uint64_t sequence,
                                               std::size_t count, double total_support,
                                               const Fit& fit, const Support& support) {
  std::array<Hypothesis, 2> best;
  if (count < kSampleSize) return best;
  Sampler sampler(config.seed, sequence);
  int needed = config.max_samples;
  for (int k = 0; k < needed; ++k) {
    Hypothesis candidate;
    if (!fit(sampler.draw(count), candidate.T_previous_current)) continue;
    candidate.support = support(candidate.T_previous_current, best[1].support);
    if (candidate.support <= best[1].support) continue;
    best[1] = candidate;
    if (best[1].support <= best[0].support) continue;
    std::swap(best[0], best[1]);
    needed = samples_needed(best[0].support / total_support, config.confidence, config.max_samples);
  }
  return best;
}

}  // namespace egomod
