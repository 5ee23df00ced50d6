// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod {

// More only cost an allocation, once.
inline constexpr std::size_t kReservedTracks = 2048;
inline constexpr std::size_t kReservedObjects = 64;
inline constexpr std::size_t kReservedNoiseBins = 32;

// How fast a point went over its last pairs, by where it was measured in them and nothing else.
inline constexpr std::array<std::size_t, 5> kRecentPairs{3, 4, 6, 8, 11};
struct RecentVelocities {
  struct Window {
    Eigen::Vector3d velocity_mps;
    double gain_hz2;  // its variance by that of a position
    double span_s;
  };
  std::array<Window, kRecentPairs.size()> windows;
  std::size_t count = 0;
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();  // as measured in one pair
};

// One track measured in two pairs, seen from the later one (left camera axes).
struct PointSample {
  std::size_t track = 0;  // index into TrackSet::tracks
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  // Along which the image tells least of where it is; zero where no direction is much worse.
  Eigen::Vector2d weak_axis = Eigen::Vector2d::Zero();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // relative to the static world
  Eigen::Matrix3d velocity_covariance_m2ps2 = Eigen::Matrix3d::Zero();
  const RecentVelocities* recent = nullptr;  // of what moves; lives as long as this pair
  double learnt_s = 0.0;  // for how long that has been learnt, of what moves; 0: since it stood
  bool stood = false;     // when it began to be
  // Spectral density of the acceleration that its filter is ready for; 0: it is not filtered.
  double agility_m2ps3 = 0.0;
  double chi2 = 0.0;  // of the displacement under "static", 3 degrees of freedom
  double motion_probability = 0.0;
  double evidence = 0.0;  // log likelihood ratio, moving over static
  bool moves = false;
  bool leaps = false;      // by one long interval only
  bool left_only = false;  // depth and motion are carried on from when the right camera saw it
  bool stands = false;     // neither of them: no opinion
};

// The axis of largest error of a left position, (uu, uv, vv), if it is clearly larger than across.
[[nodiscard]] Eigen::Vector2d weak_axis(double uu_px2, double uv_px2, double vv_px2);

// Finite, positive disparity, nearer than `max_depth_m`, usable covariance.
[[nodiscard]] bool is_usable(const StereoCamera& camera, const StereoObservation& observation,
                             double max_depth_m);

// The step from the reference pair to this one, and the noise that no single image tells.
struct Step {
  Eigen::Isometry3d T_current_reference = Eigen::Isometry3d::Identity();
  Matrix6d motion_covariance = Matrix6d::Zero();  // of T_reference_current, right perturbation
  double duration_s = 0.0;
  double floor_px = 0.0;
  double disparity_bias_px = 0.0;  // common to both observations
  double flow_error_share = 0.0;   // of the length of a static point's path
};

// Residual in (u, v, disparity), where noise is near Gaussian, under "static".
struct Residual {
  Eigen::Vector3d value_px;
  Eigen::Matrix3d covariance_px2;
  // d(residual) / d(xi) of T_reference_current * Exp(xi).
  Eigen::Matrix<double, 3, 6> motion_jacobian;
};

[[nodiscard]] Residual static_residual(const StereoCamera& camera,
                                       const StereoObservation& reference,
                                       const StereoObservation& current, const Step& step);

// Position, velocity and whitened displacement of one point: thesis eqs. 21-25 with the noise
// carried along. Both observations must be usable.
[[nodiscard]] PointSample measure_point(const StereoCamera& camera,
                                        const StereoObservation& reference,
                                        const StereoObservation& current, const Step& step);

// Log likelihood ratio of "moves with a velocity from N(0, prior^2 I)" over "static" for a measured
// velocity: the broad prior pays for its width (Occam), so that noise alone speaks for "static".
[[nodiscard]] double motion_log_ratio(const Eigen::Vector3d& velocity_mps,
                                      const Eigen::Matrix3d& covariance_m2ps2, double prior_mps);
[[nodiscard]] double logistic(double x);

// False for a pair that was skipped or rejected: nothing new is known of anything.
[[nodiscard]] bool was_tracked(const TrackSet& tracks);
[[nodiscard]] bool is_finite(const Eigen::Isometry3d& T);
// Of the rig over the last pair, in current left camera axes; zero when it is unknown.
[[nodiscard]] Eigen::Vector3d rig_velocity(const Egomotion& motion);
// Clears `objects` for this pair, keeping its memory.
void begin(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects);

}  // namespace egomod
