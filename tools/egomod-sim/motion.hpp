// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "synthetic_world.hpp"

namespace egomod::sim {

using test_support::Trajectory;

// How far something has come. Without start and go times it has always moved; else it starts and
// stops within ramp_s. Its speed never turns round: what brakes stays at rest.
struct SpeedProfile {
  double speed_mps = 0.0;
  double acceleration_mps2 = 0.0;
  double start_s = 0.0;
  double go_s = 0.0;     // stops after it; 0: never
  double pause_s = 0.0;  // goes again after it; 0: never
  double ramp_s = 0.5;
};
[[nodiscard]] double distance_m(const SpeedProfile& profile, double t_s);

// A place on the floor: x to the right, z ahead; heading 0 looks along z, positive to the right.
struct PlanPose {
  double x_m = 0.0;
  double z_m = 0.0;
  double heading_rad = 0.0;
};

// Straight where the curvature is 0.
struct PathPiece {
  PlanPose start;
  double length_m = 0.0;
  double curvature_pm = 0.0;
};
using Path = std::vector<PathPiece>;

// Unbounded: a line or a circle.
[[nodiscard]] Path endless_path(const PlanPose& start, double curvature_pm);
// Through the points; corners are rounded to the radius as far as the legs allow. At least two
// points; its ends are ends.
[[nodiscard]] Path rounded_path(const std::vector<Eigen::Vector2d>& points_m, double radius_m);
[[nodiscard]] PlanPose pose_at(const Path& path, double along_m);

struct Motion {
  Path path;
  SpeedProfile profile;
  double spin_radps = 0.0;  // in place, positive to the right; then the profile's speed is 1
  double facing_rad = 0.0;  // from the direction of motion
};
[[nodiscard]] PlanPose pose_at(const Motion& motion, double t_s);
// How far it has come along its path, whose end it does not pass; 0 where it turns in place.
[[nodiscard]] double way_m(const Motion& motion, double t_s);

}  // namespace egomod::sim
