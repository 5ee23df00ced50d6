// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/stereo_pair.hpp"
#include "egomod/core/time.hpp"
#include "egomod/core/wheels.hpp"

namespace egomod {

// A scene point in one rectified pair. Covariance (px^2) is the upper triangle of the 3x3 matrix in
// order uu uv ud vv vd dd.
struct StereoObservation {
  float u_px = 0.0F;
  float v_px = 0.0F;
  float disparity_px = 0.0F;
  std::array<float, 6> covariance_px2{};
};

// One scene point followed over pairs. Its identity is never reused.
struct Track {
  std::uint64_t id = 0;      // > 0
  std::uint32_t age = 0;     // pairs since it was seeded; 0: seeded in this pair
  bool has_current = false;  // `current` is a valid stereo observation of this pair
  bool has_previous =
      false;  // `previous` is a valid stereo observation of the previous tracked pair
  // What moves and has left the right image: `current` is where the left one shows it; the
  // disparity is the last one, carried on.
  bool left_only = false;
  bool reanchored = false;  // its template was renewed in this pair: the left position may step
  float ncc = 0.0F;         // template against this left image, -1..1
  float ncc_right = 0.0F;   // this left patch against this right image, -1..1
  float min_eigenvalue =
      0.0F;  // of the structure tensor of the normalised patch, noise removed, 1/px^2
  StereoObservation current;
  StereoObservation previous;
};

enum class TrackStatus : std::uint8_t {
  kOk,
  kFirst,     // the first pair: nothing to compare with
  kReseeded,  // a hole, a cut or a new image size: no track survived
  kNotRun,    // the pair was skipped or rejected; tracks of the last good pair wait
  kFew,       // too little texture: covered lens, white wall, darkness, blur
};

// How the right camera has turned since it was calibrated, as it seems; disparities are those of a
// camera that has not.
struct RightCameraTurn {
  bool is_off = false;                                 // surely; else all is zero
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  // rotation vector: pitch, yaw, roll
  double yaw_sigma_rad = 0.0;  // of what is taken out: it puts all disparities off alike
  bool has_changed = false;    // what is taken out, in this pair: no track reaches back
};

// The tracks of one pair, and what later stages need to know of it.
struct TrackSet {
  std::uint64_t sequence = 0;
  Nanoseconds exposure{0};
  Nanoseconds previous_exposure{0};  // of the pair that Track::previous belongs to
  PairStatus pair_status = PairStatus::kOk;
  bool discontinuity = false;  // none of the tracks reaches back beyond this pair
  TrackStatus status = TrackStatus::kOk;
  StereoCamera camera;
  std::optional<WheelPose> wheels{};
  Eigen::Isometry3d T_body_camera = default_T_body_camera();
  RightCameraTurn right_turn{};
  int max_tracks = 0;         // as many as would be followed
  std::vector<Track> tracks;  // ascending id
};

}  // namespace egomod
