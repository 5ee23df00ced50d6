// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "egomod/moving_objects/rayleigh.hpp"
#include "moving_objects/group_shape.hpp"
#include "moving_objects/grouping.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// The method of A. Abaabu, "Independently Moving Objects Detection based on Stereo Visual
// Odometry", section IV: RANSAC outliers of two pairs, their velocities, Bayes decision,
// discretised velocity, proximity groups. Every group is MOVING at once; only identities outlive a
// pair.
class ThesisMethod {
 public:
  explicit ThesisMethod(const MovingObjectsConfig& config);
  void detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects);

 private:
  void measure(const TrackSet& tracks, const Egomotion& motion);
  void decide(const Egomotion& motion);
  void group();
  void describe(std::vector<MovingObject>& objects);
  void name(Nanoseconds exposure, std::vector<MovingObject>& objects);
  void report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const;
  [[nodiscard]] MovingObject object_of(Members members) const;

  const MovingObjectsConfig config_;
  const RayleighClassifier classifier_;
  const double threshold_mps_;
  std::vector<PointSample> points_;
  std::vector<Grouper::Index> moving_;  // into points_
  std::vector<Eigen::Vector3d> bins_;   // discretised velocity of each of moving_
  std::vector<std::int64_t> object_of_point_;
  std::vector<Grouper::Index> members_;
  Grouper grouper_;
  struct Previous {
    std::int64_t id;
    PixelRect rectangle;
    double age_s;
  };
  std::vector<Previous> previous_;
  Nanoseconds previous_exposure_{0};
  std::int64_t last_id_ = 0;
};

}  // namespace egomod
