// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/egomotion/solution.hpp"

namespace egomod {

struct WheelsConfig {
  bool enable = true;
  // What slip makes of a way and of a turn: standard deviations.
  double sigma_per_m = 0.1;
  double sigma_per_rad = 0.1;
};

// The rig's motion between two pairs as the wheels saw it, in left camera frames, and how far it
// can be believed. A wheel neither rises nor tilts, but the body on it does.
struct WheelsMotion {
  Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  // right perturbation

  // Squared Mahalanobis distance between the two motions.
  [[nodiscard]] double surprise(const Solution& solution) const;
};

// From this surprise on wheels and estimate may contradict each other; from the second on they do.
// Wheels rather slide than follow a chi-square law: five standard deviations, not three.
inline constexpr double kSuspicion = 9.0;
inline constexpr double kContradiction = 25.0;

// Turns the wheels' poses into motions, and finds out when they cannot be believed at all. An
// encoder that sticks, or a wheel that loses its grip, changes its speed at once, which no base can
// do; from then on the wheels do not count until they have been seen to follow the rig again.
// Threads: one caller.
class WheelsPrior {
 public:
  explicit WheelsPrior(const WheelsConfig& config) : config_(config) {}

  // From the pair that was kept to this one; nothing without wheels in both, or while they do not
  // count. Call once a pair.
  [[nodiscard]] std::optional<WheelsMotion> motion_to(const TrackSet& tracks, double dt_s);
  // That the pair's motion is known now, whatever the wheels say; motions start at this pair.
  void keep(const TrackSet& tracks, const Solution& solution, double dt_s);
  // Motions start at this pair.
  void begin_at(const TrackSet& tracks);

 private:
  // The plane's velocity: forward, to the left, and turning to the left.
  struct Speeds {
    double time_s = 0.0;
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
  };
  void note_speeds(const Eigen::Isometry3d& T_body_motion, double dt_s, double time_s);
  [[nodiscard]] bool has_jumped(const Speeds& now) const;

  WheelsConfig config_;
  std::optional<WheelPose> kept_;
  Eigen::Isometry3d kept_T_body_camera_ = Eigen::Isometry3d::Identity();
  std::optional<WheelsMotion> last_;  // that was asked for, also while it did not count
  bool last_moves_ = false;
  std::array<Speeds, 2> speeds_;  // of the last motions
  std::size_t speeds_known_ = 0;
  double since_jump_s_ = kForgetsJump_s;
  static constexpr double kForgetsJump_s = 0.2;
  bool counts_ = true;
  double agreed_s_ = 0.0;
};

}  // namespace egomod
