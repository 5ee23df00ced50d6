// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "evaluation.hpp"

namespace egomod::thesis {

// One of the thesis's experiments, as both methods saw it.
struct Case {
  std::string folder;       // truth/, thesis.lcmlog, default.lcmlog
  eval::Evaluation thesis;  // its own pairs only; the target counts in each pair that shows it
  eval::Evaluation standard;
};

// These throw an exception that names what is missing, and how it is made.
[[nodiscard]] Case read_case(const std::string& folder);

// A further run of the thesis's method on what `folder`/truth knows.
[[nodiscard]] eval::Evaluation read_thesis_run(const std::string& folder,
                                               const std::string& record);

// The target at one instant. External frame: that of the first left camera, which is the
// thesis's up to the names of the axes: x to the right, z (its y) ahead.
struct Sighting {
  int frame = 0;
  double time_s = 0.0;
  double depth_m = 0.0;  // true, from the camera to the visible surface
  Eigen::Vector3d position_m{0.0, 0.0, 0.0};
  Eigen::Vector3d velocity_mps{0.0, 0.0, 0.0};
  double left_m = 0.0, right_m = 0.0;  // the rectangle's sides, at the position's depth
  double position_error_m = 0.0;
  double right_error_m = 0.0, up_error_m = 0.0, ahead_error_m = 0.0;  // its parts, with their sign
  double velocity_error_mps = 0.0;
};

// Of what the truth says, in each pair that shows the target.
[[nodiscard]] std::vector<Sighting> true_sightings(const eval::Truth& truth);
// Of what was reported on the target, ascending in time.
[[nodiscard]] std::vector<Sighting> sightings(const eval::Evaluation& evaluation);

// Speed of the rig along its own axis between poses that follow one another.
struct RigSpeed {
  double time_s = 0.0;
  double forward_mps = 0.0;
};
[[nodiscard]] std::vector<RigSpeed> rig_speeds(const eval::Poses& poses,
                                               const std::vector<double>& times_s);

}  // namespace egomod::thesis
