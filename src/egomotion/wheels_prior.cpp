// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/wheels_prior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

// What wheels do not see of a base that drives as it should: play, bumps, the delay of a reading.
constexpr double kForward_mps = 0.03;
constexpr double kSideways_mps = 0.03;
constexpr double kTurn_radps = 0.05;
// ... and what they cannot see at all.
constexpr double kRise_mps = 0.2;
constexpr double kTilt_radps = 0.5;
// A wheel that slips on one side turns the base.
constexpr double kTurnPerWay_radpm = 0.1;

// More than any base on wheels can do, beyond what readings are noisy.
constexpr double kJump_mps2 = 5.0;
constexpr double kJump_radps2 = 15.0;
constexpr double kNoise_mps = 0.1;
constexpr double kNoise_radps = 0.3;
constexpr double kMoves_mps = 0.05;
constexpr double kMoves_radps = 0.1;
constexpr double kAgreedToCount_s = 0.5;

// Of a right perturbation of the body's motion.
Matrix6d body_covariance(const WheelsConfig& config, double way_m, double turn_rad, double dt_s) {
  const auto sigma = [dt_s](double share, double rate) { return std::hypot(share, rate * dt_s); };
  Vector6d s;
  s << sigma(config.sigma_per_m * way_m, kForward_mps),
      sigma(0.5 * config.sigma_per_m * way_m, kSideways_mps), kRise_mps * dt_s, kTilt_radps * dt_s,
      kTilt_radps * dt_s,
      sigma(std::hypot(config.sigma_per_rad * turn_rad, kTurnPerWay_radpm * way_m), kTurn_radps);
  return s.cwiseAbs2().asDiagonal();
}

}  // namespace

double WheelsMotion::surprise(const Solution& solution) const {
  const Vector6d xi = se3_log(T_previous_current.inverse() * solution.T_previous_current);
  return xi.dot((covariance + solution.covariance).ldlt().solve(xi));
}

std::optional<WheelsMotion> WheelsPrior::motion_to(const TrackSet& tracks, double dt_s) {
  last_.reset();
  const bool is_known =
      config_.enable && kept_ && tracks.wheels && kept_->stretch == tracks.wheels->stretch;
  if (!is_known) {
    speeds_known_ = 0;
    return std::nullopt;
  }
  const Eigen::Isometry3d T_body = kept_->T_wheels_body.inverse() * tracks.wheels->T_wheels_body;
  note_speeds(T_body, dt_s, to_seconds(tracks.exposure));
  const double way_m = T_body.translation().norm();
  const double turn_rad = so3_log(T_body.linear()).norm();
  last_moves_ = way_m > kMoves_mps * dt_s || turn_rad > kMoves_radps * dt_s;
  const Eigen::Isometry3d T_camera_body = tracks.T_body_camera.inverse();
  const Matrix6d Ad = adjoint(T_camera_body);
  last_ = WheelsMotion{kept_T_body_camera_.inverse() * T_body * tracks.T_body_camera,
                       Ad * body_covariance(config_, way_m, turn_rad, dt_s) * Ad.transpose()};
  return counts_ && since_jump_s_ >= kForgetsJump_s ? last_ : std::nullopt;
}

void WheelsPrior::note_speeds(const Eigen::Isometry3d& T_body_motion, double dt_s, double time_s) {
  const Eigen::Vector3d way = T_body_motion.translation() / dt_s;
  const Speeds now{time_s, {way.x(), way.y(), so3_log(T_body_motion.linear()).z() / dt_s}};
  since_jump_s_ = has_jumped(now) ? 0.0 : std::min(since_jump_s_ + dt_s, kForgetsJump_s);
  speeds_ = {speeds_[1], now};
  speeds_known_ = std::min(speeds_known_ + 1, speeds_.size());
}

// Against the last two: a jump between two readings shows in two motions by half.
bool WheelsPrior::has_jumped(const Speeds& now) const {
  for (std::size_t i = speeds_.size() - speeds_known_; i < speeds_.size(); ++i) {
    const double dt_s = now.time_s - speeds_[i].time_s;
    const Eigen::Vector3d change = (now.y - speeds_[i].y).cwiseAbs();
    if (change.head<2>().norm() > kNoise_mps + kJump_mps2 * dt_s ||
        change.z() > kNoise_radps + kJump_radps2 * dt_s)
      return true;
  }
  return false;
}

void WheelsPrior::keep(const TrackSet& tracks, const Solution& solution, double dt_s) {
  begin_at(tracks);
  if (!last_) return;
  const double surprise = last_->surprise(solution);
  if (surprise > kContradiction && since_jump_s_ < kForgetsJump_s) counts_ = false;
  // Both at rest tells nothing: an encoder that sticks agrees as well.
  if (surprise > kSuspicion) {
    agreed_s_ = 0.0;
  } else if (last_moves_) {
    agreed_s_ += dt_s;
  }
  if (agreed_s_ > kAgreedToCount_s) counts_ = true;
}

void WheelsPrior::begin_at(const TrackSet& tracks) {
  kept_ = tracks.wheels;
  kept_T_body_camera_ = tracks.T_body_camera;
}

}  // namespace egomod
