// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "labels.hpp"
#include "sequence.hpp"

namespace egomod::fit {

enum class PointChoice {
  kAll,
  kRansac,  // the odometry's RANSAC must agree: its inliers that rest, its outliers that move
  kRoles,   // RANSAC alone decides, as if there were no truth: all inliers, all outliers
};

// Labels the point velocities of a record (EGOMOD_TRACKS) by the truth in `truth_directory`, as
// egomod-eval scores them (point_truth.hpp). No truth is read for kRoles.
struct RecordLabels {
  Labels labels;
  std::string damage;  // why the record ended before its file did; empty if it is whole
};
[[nodiscard]] RecordLabels label_record(const std::string& log, const std::string& truth_directory,
                                        PointChoice choice = PointChoice::kAll);

// Throws an exception that names file and place, also where the objects are unknown.
[[nodiscard]] eval::Truth read_object_truth(const std::string& folder);

}  // namespace egomod::fit
