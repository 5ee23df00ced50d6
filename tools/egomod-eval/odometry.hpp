// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sequence.hpp"
#include "statistics.hpp"

namespace egomod::eval {

// Mean error over all stretches of one path length.
struct SegmentDrift {
  double length_m = 0.0;
  int segments = 0;
  double translation_percent = 0.0;
  double rotation_deg_per_m = 0.0;
};

struct RelativeDrift {
  double translation_percent = 0.0;
  double rotation_deg_per_m = 0.0;
  std::vector<SegmentDrift> per_length;
};

struct OdometryFigures {
  int truth_frames = 0;
  int frames = 0;
  bool finite = true;
  bool scored = false;  // false: fewer than two poses, nothing below has a meaning
  std::optional<Summary> pair_mm;
  std::optional<Summary> pair_mdeg;
  double path_m = 0.0;
  double turn_deg = 0.0;
  double first_aligned_rmse_m = 0.0;
  double rigid_aligned_rmse_m = 0.0;
  double end_error_m = 0.0;
  double max_error_m = 0.0;
  double end_rotation_deg = 0.0;
  // As KITTI's, over 100 to 800 m, or over 20 to 80 % of a shorter path; nothing below half a
  // metre.
  std::optional<RelativeDrift> drift;
};

// Poses of frames that both know, each relative to the first of them.
struct AlignedPoses {
  std::vector<int> frames;
  std::vector<Eigen::Isometry3d> truth;
  std::vector<Eigen::Isometry3d> estimate;
  int estimates = 0;  // within the sequence, finite or not
};

[[nodiscard]] AlignedPoses align_first(const Poses& truth, const Poses& estimate);
[[nodiscard]] OdometryFigures score_odometry(const Poses& truth, const Poses& estimate);
// Rotation angle, also exact where it is small.
[[nodiscard]] double angle_deg(const Eigen::Isometry3d& T);

}  // namespace egomod::eval
