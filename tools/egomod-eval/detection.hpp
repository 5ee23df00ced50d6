// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sequence.hpp"
#include "statistics.hpp"

namespace egomod::eval {

struct DetectionOptions {
  int min_px = 400;           // least visible pixels of an object that is due
  double max_depth_m = 15.0;  // greatest depth of one that is due
  double grace_s = 1.0;       // how long an object must have qualified before it is due
  double v90_factor = 1.5;    // qualifies from this many times v90 on; 0: whatever moves
  int first_frame = 1;        // motion takes two pairs
  int every = 1;              // only frames divisible by this count
  // Ascending; only these frames, at the rate that they come at. Nothing: all.
  std::optional<std::vector<int>> only = std::nullopt;
};

// What an estimate that lies on a true object is worth.
enum class Duty {
  kDue,    // must be found
  kGrace,  // may be found
  kStill,  // must not be reported
  kOther,  // counts neither way: moves, but too small, far, slow; or stopped just now
};

struct Match {
  int frame = 0;
  Detection estimate;
  TruthObject truth;
  Duty duty = Duty::kDue;
};

struct ObjectFigures {
  std::string type;
  int due = 0;
  int found = 0;
  int switches = 0;
  int tracks = 0;
  std::optional<double> delay_s;
};

struct DepthFigures {
  double from_m = 0.0, to_m = 0.0;
  int due = 0;
  double recall = 0.0;
  std::optional<Summary> position_m;
  std::optional<Summary> velocity_mps;
  std::optional<Summary> speed_mps;
};

struct DetectionFigures {
  int frames = 0;
  double duration_s = 0.0;
  int rows_outside = 0;
  std::optional<double> time_mismatch_s;  // nothing: no time to compare
  int tp = 0, fp = 0, fn = 0;
  int duplicates = 0;
  int fp_on_still = 0;
  int ignored = 0;
  std::optional<double> precision, recall, f1;
  double false_per_pair = 0.0;
  double false_per_minute = 0.0;
  std::optional<Summary> position_m, position_percent, position_axial_m, position_lateral_m;
  std::optional<Summary> position_to_centre_m;  // of the box, not of the visible surface
  std::optional<Summary> velocity_mps, speed_mps;
  std::optional<Eigen::Vector3d> velocity_bias_mps;
  std::optional<double> min_depth_m, max_depth_m, max_depth_any_m;
  std::vector<DepthFigures> by_depth;
  std::map<std::string, ObjectFigures> objects;
  int switches = 0;
  int never_detected = 0;
  std::optional<Summary> delay_s;
  std::vector<Match> matches;  // estimates with what they were taken for
};

[[nodiscard]] DetectionFigures score_detection(const Truth& truth,
                                               const ByFrame<Detection>& detections,
                                               const DetectionOptions& options);

// Speed that 20 points of 0.25 px disparity noise let show with 90 % power within a second, in the
// direction of the object's motion and at its depth.
[[nodiscard]] double v90_mps(const TruthObject& object, double rate_hz, double focal_px,
                             double baseline_m);
// Intersection over union; pixels are counted, so that a rectangle includes its edges.
[[nodiscard]] double overlap(const Rectangle& a, const Rectangle& b);

}  // namespace egomod::eval
