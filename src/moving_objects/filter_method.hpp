// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "moving_objects/filter_bank.hpp"
#include "moving_objects/motion_groups.hpp"
#include "moving_objects/noise_model.hpp"
#include "moving_objects/noise_scale.hpp"
#include "moving_objects/object_table.hpp"
#include "moving_objects/point_sample.hpp"
#include "moving_objects/rig_pose.hpp"
#include "moving_objects/trails.hpp"

namespace egomod {

// Evidence over time: each track is filtered under "stands" and under "moves", and what foretells
// its measurements better wins, in its own time. All tracks are tested, not only the odometry's
// outliers (its gate hides what is slow). Groups of moving tracks become objects by the evidence
// that they have together.
class FilterMethod {
 public:
  explicit FilterMethod(const MovingObjectsConfig& config);
  void detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects);

 private:
  void filter(const TrackSet& tracks, const Egomotion& motion);
  void follow_rig(const Egomotion& motion);
  [[nodiscard]] MotionPrior prior() const;
  [[nodiscard]] FilterStep step_of(const StereoCamera& camera) const;
  [[nodiscard]] double least_updates() const;
  [[nodiscard]] bool rest_fits() const;
  [[nodiscard]] bool rest_is_off() const;
  void measure(const StereoCamera& camera, const RowTiming& rows, const Track& track,
               FilterSlot at);
  [[nodiscard]] bool keeps_to_its_object(std::size_t track) const;
  void measure_left(const StereoCamera& camera, const RowTiming& rows, const Track& track,
                    FilterSlot at);
  void learn_noise(const StereoCamera& camera, const Track& track, FilterSlot at);
  [[nodiscard]] double agility_m2ps3(const FilterBlock& filters, std::size_t lane) const;
  [[nodiscard]] PointSample sample(FilterSlot at) const;
  // How it went over its last pairs.
  void recall(const StereoCamera& camera, FilterSlot at, PointSample& point);
  void report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const;
  [[nodiscard]] PointState state_of(const PointSample& point) const;

  const MovingObjectsConfig config_;
  FilterBank filters_;
  Trails trails_;
  std::uint32_t reset_count_ = 0;
  Nanoseconds now_{0};
  double interval_s_ = 0.0;  // before this pair
  bool is_slow_ = false;     // pairs are far apart
  RigPose rig_;
  Eigen::Vector3d rig_velocity_mps_ = Eigen::Vector3d::Zero();  // smoothed, current camera axes
  int rig_pairs_ = 0;                                           // in it
  std::vector<PointSample> points_;
  std::vector<RecentVelocities> recent_;  // parallel to TrackSet::tracks; of moving points only
  std::vector<double> standing_chi2_;
  NoiseScale noise_;
  NoiseModel noise_model_;
  MotionGroups groups_;
  ObjectTable objects_;
};

}  // namespace egomod
