// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "egomod/moving_objects/moving_object_detector.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {

// The method `filter` before a synthetic world.
class Filter : public ::testing::Test {
 protected:
  Filter() {
    world.pixel_sigma = 0.18;
    world.disparity_sigma_px = 0.25;
  }
  const MovingObjects& run(int pair, EstimateStatus status = EstimateStatus::kValid) {
    const TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    if (pair > 0) motion.status = status;
    detector.detect(tracks, motion, objects);
    return objects;
  }
  // A pair without images.
  void reject(int pair) {
    TrackSet rejected;
    rejected.camera = synthetic::kCamera;
    rejected.sequence = static_cast<std::uint64_t>(pair);
    rejected.exposure = world.exposure(pair);
    rejected.pair_status = PairStatus::kRejected;
    rejected.status = TrackStatus::kNotRun;
    Egomotion motion;
    motion.status = EstimateStatus::kFailed;
    detector.detect(rejected, motion, objects);
  }
  [[nodiscard]] int count(ObjectState state) const {
    return static_cast<int>(std::count_if(objects.objects.begin(), objects.objects.end(),
                                          [&](const auto& o) { return o.state == state; }));
  }
  [[nodiscard]] int moving() const { return count(ObjectState::kMoving); }
  // Of the first one that is MOVING; 0 when none is.
  [[nodiscard]] std::int64_t moving_id() const {
    const auto object = std::find_if(objects.objects.begin(), objects.objects.end(),
                                     [](const auto& o) { return o.state == ObjectState::kMoving; });
    return object == objects.objects.end() ? 0 : object->id;
  }
  // Time from the start of the world to the first MOVING; 1000 when there is none by `limit_s`.
  double delay_s(double limit_s) {
    for (int pair = 0; world.time_s(pair) <= limit_s; ++pair) {
      run(pair);
      if (moving() > 0) return world.time_s(pair);
    }
    return 1000.0;
  }
  void expect_one_at_most(int first_pair, int end) {
    for (int pair = first_pair; pair < end; ++pair) {
      run(pair);
      ASSERT_LE(moving(), 1) << "pair " << pair;
    }
  }
  void rest_rig() {
    world.rig_velocity_mps.setZero();
    world.rig_yaw_rate_radps = 0.0;
  }
  // From this pair on the points from `first` on move with another velocity.
  void turn(int pair, std::size_t first, const Eigen::Vector3d& velocity_mps) {
    for (std::size_t i = first; i < world.points.size(); ++i) {
      synthetic::Point& point = world.points[i];
      point.at_start_m += world.time_s(pair) * (point.velocity_mps - velocity_mps);
      point.velocity_mps = velocity_mps;
    }
  }

  synthetic::World world;
  MovingObjectDetector detector{{.method = MovingObjectsMethod::kFilter}};
  MovingObjects objects;
};

}  // namespace egomod
