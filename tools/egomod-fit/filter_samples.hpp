// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "decision_cut.hpp"

namespace egomod::fit {

// What the method filter decided by in records, labelled by their truth.
struct FilterSamples {
  ClassValues evidence, chi2;  // of each point in each pair
  Score decided;               // as the detector decided those points
  // Of each object over its life, by the truth of most of its points: the most that its moving
  // points told together in one pair, and the most that the leaky sum over pairs reached.
  ClassValues pair_evidence, summed_evidence;
  // Mean square of movers' speeds along an axis, less that of the rig, with which the prior widens.
  double velocity_variance_m2ps2 = 0.0;
  std::size_t velocities = 0;

  void sort();
};

// Adds one record's. Returns why the record ended before its file did; empty if it is whole. Throws
// an exception that names file and place, also where the tracks carry no evidence.
[[nodiscard]] std::string add_record(const std::string& log, const std::string& truth_folder,
                                     double error_correlation, FilterSamples& samples);

}  // namespace egomod::fit
