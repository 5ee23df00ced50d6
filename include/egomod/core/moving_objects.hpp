// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "egomod/core/time.hpp"

namespace egomod {

enum class ObjectState : std::uint8_t { kTentative, kMoving, kCoasting, kStopped };

// What is known about one track's own motion, for viewers and scoring.
enum class PointState : std::uint8_t { kUnknown, kStatic, kMoving, kUnobservable };

// Velocity of a track relative to the static world, left camera axes of this pair.
struct PointMotion {
  std::uint64_t track_id = 0;
  PointState state = PointState::kUnknown;
  std::int64_t object_id = 0;  // 0: none
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  float motion_probability = 0.0F;
  float evidence = 0.0F;  // log likelihood ratio, moving over static; 0 where a method has none
  float chi2 = 0.0F;      // of the velocity against rest, 3 degrees of freedom; 0 as above
};

// Inclusive pixel rectangle in the rectified left image; empty where u_max_px < u_min_px.
struct PixelRect {
  float u_min_px = 0.0F;
  float v_min_px = 0.0F;
  float u_max_px = 0.0F;
  float v_max_px = 0.0F;
};

// A group of tracks that move as one. Position and velocity in left camera axes of this pair;
// velocity is relative to the static world, at `position_m`.
struct MovingObject {
  std::int64_t id = 0;  // > 0, never reused; one that was lost may come back
  ObjectState state = ObjectState::kTentative;
  double age_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d velocity_covariance_m2ps2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  PixelRect rectangle;
  Eigen::Vector3d extent_m = Eigen::Vector3d::Zero();  // along left camera axes
  int points = 0;                                      // measured in this pair
  double speed_mps = 0.0;
  double speed_sigma_mps = 0.0;
  double motion_probability = 0.0;
};

// What tracks of one sort err, learnt from the residuals of those that stand.
struct NoiseBin {
  double least_depth_m = 0.0;
  double most_depth_m = 0.0;  // 0: no limit
  bool is_rich = false;       // their texture is more than the median's
  bool is_old = false;        // followed for 10 pairs or more
  double weight = 0.0;        // observations that it rests on, older ones count less
  double pixel_factor = 1.0;  // on the variances that the features stage states
  double disparity_factor = 1.0;
  double pixel_sigma_px = 0.0;  // of a left position along each axis
  double disparity_sigma_px = 0.0;
};

struct MovingObjects {
  std::uint64_t sequence = 0;
  Nanoseconds exposure{0};
  bool has_run = false;  // false: the pair was skipped, no object message is recorded
  std::vector<MovingObject> objects;
  std::vector<PointMotion> points;  // tracks with an opinion; may be empty
  std::vector<NoiseBin> noise;      // may be empty
};

}  // namespace egomod
