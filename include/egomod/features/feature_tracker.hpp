// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "egomod/core/instruction_set.hpp"
#include "egomod/core/stereo_pair.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod {

struct FeaturesConfig {
  int max_tracks = 0;                  // 0: `usual_max_tracks`
  double max_disparity_share = 0.4;    // of the image width: 256 px at 640
  double search_radius_share = 0.625;  // of the image width, when no motion is known: 400 px at 640
};

// As many as the instruction set follows in about the same share of a pair's time.
[[nodiscard]] int usual_max_tracks(InstructionSet set);
// What `config` comes to on this machine.
[[nodiscard]] int max_tracks(const FeaturesConfig& config);

// Follows corners through both cameras: left previous -> left current -> right current -> right
// previous, subpixel, with a covariance for each observation.
// The covariances hold over a track's life. From one pair to the next, errors are about half of
// what they say, since both observations are measured against the same template and share its
// error; only new tracks, and renewed ones (Track::reanchored), err independently.
// Threads: one caller.
class FeatureTracker {
 public:
  explicit FeatureTracker(const FeaturesConfig& config);
  ~FeatureTracker();

  // `tracks` is refilled in place. A skipped or rejected pair leaves the tracker as it was.
  void track(const StereoPair& pair, TrackSet& tracks);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace egomod
