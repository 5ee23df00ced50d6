// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "moving_objects/lag_history.hpp"
#include "moving_objects/motion_groups.hpp"
#include "moving_objects/noise_scale.hpp"
#include "moving_objects/object_table.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// The thesis's stages on every pair, each compared with one a fraction of a second before it: a
// displacement grows with time, noise does not. All tracks are tested, not only the odometry's
// outliers (its gate hides what is slow), by their displacement in units of its own noise.
class LagMethod {
 public:
  explicit LagMethod(const MovingObjectsConfig& config);
  void detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects);

 private:
  void measure(const TrackSet& tracks, const Egomotion& motion);
  void scale_noise(const Egomotion& motion);
  void decide();
  void report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const;
  [[nodiscard]] PointState state_of(const PointSample& point) const;

  const MovingObjectsConfig config_;
  LagHistory history_;
  std::vector<ObservationCursor> cursors_;
  std::vector<Step> steps_;  // of each cursor
  std::vector<PointSample> points_;
  std::vector<double> inlier_chi2_;
  NoiseScale noise_;  // learnt from the odometry's inliers
  MotionGroups groups_;
  ObjectTable objects_;
};

}  // namespace egomod
