// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "sequence.hpp"

namespace egomod::eval {

// What a record says of one pair beyond what an export holds, in the left camera frame. Covariances
// as pose_t has them: translation (m), rotation (rad), right perturbation.
struct PoseEvidence {
  int frame = 0;
  int reset_count = 0;
  bool estimated = false;  // false: the last pose again
  // First left camera from this one, as recorded.
  Eigen::Isometry3d T_first_camera = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // Of the motion since the previous pair; nothing where none was estimated.
  std::optional<Eigen::Matrix<double, 6, 6>> motion_covariance;
};

struct PointEvidence {
  int frame = 0;
  double u_px = 0.0, v_px = 0.0, depth_m = 0.0;
  double speed_mps = 0.0;
  bool moving = false;  // decided so
  std::int64_t track = 0;
  double disparity_px = 0.0;
};

// What a record says that its tracks of one range of depths err: standard deviations, root mean
// square over its pairs and bins, by their weights.
struct LearntNoise {
  double pixel_px2 = 0.0, disparity_px2 = 0.0;  // sums, until divided by the weight
  double weight = 0.0;
};
using NoiseByDepth = std::map<std::pair<double, double>, LearntNoise>;  // from, to; to 0: no limit

struct Record {
  Estimate estimate;
  std::vector<PoseEvidence> poses;
  std::vector<int> processed;                        // frames with a list of objects, ascending
  std::optional<std::vector<PointEvidence>> points;  // nothing: recorded without EGOMOD_TRACKS
  NoiseByDepth noise;
};

// A log of egomodd. Throws an exception that names file and place, also where the log is damaged.
[[nodiscard]] Record read_record(const std::string& log);

}  // namespace egomod::eval
