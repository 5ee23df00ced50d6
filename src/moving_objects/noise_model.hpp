// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "egomod/core/moving_objects.hpp"

namespace egomod {

// What sort of track it is.
struct NoiseKey {
  double depth_m = 0.0;
  double texture = 0.0;  // Track::min_eigenvalue
  double age_pairs = 0.0;
};

// A track's measurement against where the standing filter expected it.
struct NoiseResidual {
  double u_px = 0.0, v_px = 0.0, disparity_px = 0.0;
  double variance_u_px2 = 0.0, variance_v_px2 = 0.0, variance_disparity_px2 = 0.0;  // as stated
};

// Learns online by what factors the variances that are stated for pixels and for disparities are
// off, by depth, texture and age: a bin of tracks each, with a weight that forgets. A bin that
// rests on little is drawn to the factor that is common to all. Medians, so that movers and
// mismatches among the tracks do little. Allocates nothing.
class NoiseModel {
 public:
  struct Factors {
    double pixel = 1.0;
    double disparity = 1.0;
  };

  explicit NoiseModel(double floor_px) : floor_px2_(floor_px * floor_px) {}

  [[nodiscard]] Factors factors(const NoiseKey& key) const;
  void add(const NoiseKey& key, const NoiseResidual& residual);
  // What was added since the last call is learnt; `dt_s` is how long ago that was.
  void learn(double dt_s);
  // Bins that something is known of.
  void report(std::vector<NoiseBin>& bins) const;

 private:
  // Of one of the two factors, in one bin.
  struct Scale {
    double log_factor = 0.0;
    double factor = 1.0;
    double weight = 0.0;
    double variance_px2 = 0.0;  // stated, running mean
    double sum_px2 = 0.0;       // the rest is of the pairs since the last `learn`
    int above = 0;              // the median of chi-square with 1 degree of freedom
    int count = 0;

    void add(double residual_px, double variance, double floor_px2);
    void learn(double forget);
    void forget_pair();
  };
  struct Bin {
    Scale pixel, disparity;
  };

  static constexpr std::array kDepthEdges_m{2.0, 4.0, 8.0, 16.0};
  static constexpr std::size_t kDepths = kDepthEdges_m.size() + 1;
  static constexpr std::size_t kBins = 4 * kDepths;  // two of texture, two of age

  [[nodiscard]] std::size_t bin_of(const NoiseKey& key) const;
  [[nodiscard]] double shrunk(const Scale& own, const Scale& common) const;

  double floor_px2_;
  std::array<Bin, kBins> bins_{};
  Bin common_;
  double log_texture_ = 0.0;  // running median of the logarithm
  int richer_ = 0, seen_ = 0;
  double texture_weight_ = 0.0;
};

}  // namespace egomod
