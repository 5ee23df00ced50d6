// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "egomod/features/corners.hpp"
#include "egomod/features/wide_matcher.hpp"
#include "stereo_images.hpp"
#include "temporal_alignment.hpp"
#include "track_store.hpp"

namespace egomod {

// Finds points again after a motion that nothing predicts: pairs up to a second apart, the first
// motion after a start. Descriptors of the lost points are matched with those of fresh corners.
// Threads: one caller.
class Bridging {
 public:
  Bridging(int capacity, const CornerConfig& corners, double search_radius_share);

  void find_lost(const StereoImages& previous, const StereoImages& current,
                 TemporalAlignment& alignment, TrackStore& store);

 private:
  void describe_lost(const Pyramid& previous, const TrackStore& store);
  void describe_corners(const Pyramid& current);

  CornerDetector detector_;
  WideMatcher matcher_;
  float radius_share_;
  std::vector<Corner> corners_;
  std::vector<std::size_t> lost_;
  std::vector<DescribedPoint> olds_;
  std::vector<DescribedPoint> candidates_;
  std::vector<WideMatch> matches_;
};

}  // namespace egomod
