// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod::test_support {

// Features and egomotion together in a room that the rig drives through, one pair at a time.
class RenderedDrive {
 public:
  using Spoil = std::function<void(StereoPair&)>;

  // The pair at `t_s`, after `spoil` has had its way with the images.
  const Egomotion& see(double t_s, const Spoil& spoil = {}) {
    StereoPair pair;
    pair.sequence = sequence_++;
    pair.exposure = pair.right_exposure = Nanoseconds(std::llround(t_s * 1e9));
    pair.calibration.camera = world_.camera();
    world_.render(t_s, pair.left, pair.right);
    if (spoil) spoil(pair);
    before_ = motion_.T_first_current;
    before_s_ = last_s_;
    tracker_.track(pair, tracks_);
    estimator_.estimate(tracks_, motion_);
    last_s_ = t_s;
    return motion_;
  }
  // `sequence` numbers that were never seen, since their pairs were dropped.
  void skip_numbers(std::uint64_t count) { sequence_ += count; }

  [[nodiscard]] const Egomotion& motion() const { return motion_; }
  [[nodiscard]] const TrackSet& tracks() const { return tracks_; }
  // How far the published pose has gone since the last one, and how far that is from the truth.
  [[nodiscard]] double step_m() const {
    return (before_.inverse() * motion_.T_first_current).translation().norm();
  }
  [[nodiscard]] double step_error_m() const {
    const Eigen::Isometry3d truth =
        world_.T_first_current(before_s_).inverse() * world_.T_first_current(last_s_);
    const Eigen::Isometry3d found = before_.inverse() * motion_.T_first_current;
    return se3_log(truth.inverse() * found).head<3>().norm();
  }

 private:
  SyntheticWorld world_{static_room(), kinect_pair(320), {.noise_sigma = 1.0}};
  FeatureTracker tracker_{FeaturesConfig{}};
  EgomotionEstimator estimator_{EgomotionConfig{}};
  TrackSet tracks_;
  Egomotion motion_;
  Eigen::Isometry3d before_ = Eigen::Isometry3d::Identity();
  std::uint64_t sequence_ = 0;
  double before_s_ = 0.0;
  double last_s_ = 0.0;
};

}  // namespace egomod::test_support
