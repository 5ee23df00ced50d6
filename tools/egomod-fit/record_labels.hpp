// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "labels.hpp"

namespace egomod::fit {

enum class PointChoice {
  kAll,
  kRansac,  // the odometry's RANSAC must agree: its inliers that rest, its outliers that move
  kRoles,   // RANSAC alone decides, as if there were no truth: all inliers, all outliers
};

// Labels the point velocities of a record (EGOMOD_TRACKS) by the truth's objects.csv in
// `truth_directory`: inside a moving object's visible rectangle and depth is moving, outside every
// rectangle is static, the rest is left out. No truth is read for kRoles.
struct RecordLabels {
  Labels labels;
  std::string damage;  // why the record ended before its file did; empty if it is whole
};
[[nodiscard]] RecordLabels label_record(const std::string& log, const std::string& truth_directory,
                                        PointChoice choice = PointChoice::kAll);

}  // namespace egomod::fit
