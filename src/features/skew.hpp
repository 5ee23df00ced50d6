// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/core/time.hpp"
#include "egomod/features/image_point.hpp"
#include "track_store.hpp"

namespace egomod {

// Where the right image was exposed before or after the left one, the rig has moved meanwhile, and
// the right image shows each point displaced: by f * 10 ms * 0.7 rad/s = 3.7 px at 40 degrees a
// second, as much as a depth error of a tenth at 5 m. Tells that displacement from the rig's
// motion, so that disparities are those of the left exposure. Threads: one caller.
class Skew {
 public:
  // `skew`: from the left to the right exposure. `interval`: since the left exposure of the last
  // pair. Without `moving_on` nothing is known of the motion before.
  void begin_pair(const StereoCamera& camera, Nanoseconds skew, Nanoseconds interval,
                  bool moving_on);
  // The right camera has turned since it was calibrated: see RightTurn.
  void turn_right_camera(const Eigen::Vector3d& turn_rad);
  // As soon as this pair's motion is known, or that it cannot be. It goes on during the skew, and
  // so does its change since the last pair.
  void move(const std::optional<Eigen::Isometry3d>& T_current_previous);

  // By how much the disparity of a resting point differs from what is expected of it.
  struct Surprise {
    ImagePoint left;
    float disparity_px = 0.0F;  // expected
    float surprise_px = 0.0F;   // found, with the shift of this skew, less expected
  };
  // Where most points are surprised alike, the rig has turned otherwise during the skew than before
  // it, and the shift becomes what they tell, for some pairs; small surprises are noise.
  void turn(std::span<const Surprise> surprises);

  // Nothing displaces what the right image shows.
  [[nodiscard]] bool none() const { return is_synchronised() && turn_rad_.isZero(0.0); }
  [[nodiscard]] bool is_synchronised() const { return skew_s_ == 0.0; }

  // How far from its place in a right image without skew a resting point is seen.
  [[nodiscard]] ImagePoint shift(ImagePoint left, float disparity_px) const;
  // What a point adds to that by a motion of its own, in pixels since the last pair.
  [[nodiscard]] ImagePoint own_shift(ImagePoint own_motion) const;
  // Variance that the shift gives a disparity; zero without skew.
  [[nodiscard]] float variance_px2(float disparity_px) const;

 private:
  [[nodiscard]] Eigen::Vector2d after_turn(const Eigen::Vector2d& right_px) const;

  StereoCamera camera_;
  double skew_s_ = 0.0;
  double interval_s_ = 0.0;
  double last_interval_s_ = 0.0;
  std::optional<Vector6d> velocity_;  // of the scene against the camera: P' = velocity x P
  Eigen::Isometry3d T_later_current_ = Eigen::Isometry3d::Identity();
  double translation_sigma_m_ = 0.0;
  double rotation_sigma_rad_ = 0.0;
  int turns_in_a_row_ = 0;
  Eigen::Vector3d turn_rad_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_seen_calibrated_ = Eigen::Matrix3d::Identity();
};

}  // namespace egomod
