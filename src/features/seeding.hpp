// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "egomod/features/corners.hpp"
#include "egomod/features/disparity_search.hpp"
#include "skew.hpp"
#include "stereo_images.hpp"
#include "surroundings.hpp"
#include "track_store.hpp"

namespace egomod {

// Starts new tracks on corners that have a disparity, where the image lacks tracks.
// Threads: one caller.
class Seeding {
 public:
  Seeding(int capacity, const CornerConfig& corners, const DisparityConfig& disparity);

  void seed(const StereoImages& images, const Skew& skew, TrackStore& store);

 private:
  CornerDetector detector_;
  DisparitySearch search_;
  Surroundings surroundings_;
  std::size_t half_full_;
  std::size_t max_tries_when_half_full_;
  std::vector<ImagePoint> occupied_;
  std::vector<ImagePoint> movers_;
  std::vector<Corner> corners_;
  std::vector<PixelPosition> pixels_;
  std::vector<PixelPosition> right_shifts_;  // parallel to it; empty without skew
  std::vector<DisparityMatch> matches_;
};

}  // namespace egomod
