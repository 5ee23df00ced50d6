// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "egomod/features/disparity_search.hpp"
#include "skew.hpp"
#include "stereo_images.hpp"
#include "surroundings.hpp"
#include "track_store.hpp"

namespace egomod {

// Subpixel disparity of a left point with a plane (d + a x + b y) through its patch, from a start
// that is right to about a pixel; not valid where the patches do not agree. The right point is
// sought where `start.skew_shift` displaces it to.
[[nodiscard]] StereoMeasurement align_stereo(const StereoImages& images, ImagePoint left,
                                             const StereoMeasurement& start);

// The same where the skew tells the shift, to which the point may add one of its own.
[[nodiscard]] StereoMeasurement align_skewed(const StereoImages& images, ImagePoint left,
                                             StereoMeasurement start, const Skew& skew,
                                             ImagePoint own_shift = {});

// The patch that the right image shows of `left` at `stereo`, sought in the left image where
// `surface`, that of another point or its own, has it: moved from `left` by `off_px` along the row.
[[nodiscard]] AlignmentResult align_back(const StereoImages& images, ImagePoint left,
                                         const StereoMeasurement& stereo,
                                         const StereoMeasurement& surface, float off_px, int steps);

// The patch seen in the right image, sought in the left one, must come back to where it was.
[[nodiscard]] bool is_consistent(const StereoImages& images, ImagePoint left,
                                 const StereoMeasurement& stereo);

// The fourth side of the circle: the patch in the current right image must fall on the known place
// in the previous right image.
[[nodiscard]] bool closes_circle(const StereoImages& previous, const StereoImages& current,
                                 const FollowedPoint& point);

// Disparities of all followed points. Points without a valid one keep the last, moved on.
// Threads: one caller.
class StereoAlignment {
 public:
  StereoAlignment(int capacity, const DisparityConfig& config);

  void measure(const StereoImages& previous, const StereoImages& current, Skew& skew,
               TrackStore& store);

 private:
  void look_for_surprises(const StereoImages& current, const Skew& skew, const TrackStore& store);
  void measure_predicted(const StereoImages& previous, const StereoImages& current,
                         const Skew& skew, TrackStore& store);
  void search_lost(const StereoImages& previous, const StereoImages& current, const Skew& skew,
                   TrackStore& store);
  void find_refuted(const StereoImages& current, TrackStore& store) const;

  DisparitySearch search_;
  Surroundings surroundings_;
  std::vector<std::size_t> lost_;
  std::vector<PixelPosition> pixels_;
  std::vector<PixelPosition> right_shifts_;  // parallel to it; empty without skew
  std::vector<DisparityMatch> matches_;
  std::vector<Skew::Surprise> surprises_;
};

}  // namespace egomod
