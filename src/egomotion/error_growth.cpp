// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/error_growth.hpp"

#include <algorithm>
#include <cmath>

#include "egomod/egomotion/statistics.hpp"

namespace egomod {
namespace {

constexpr double kCommonErrorS = 1.5;
// So that the covariance by which the pose's grows in 1 s is that of the motion in 1 s: found over
// resting and moving rigs in rendered worlds, where it needs 2 and 4 to 5 covariances of one pose.
constexpr double kLastingPerS = 1.75;
constexpr double kLastingOfNew = 6.0;
constexpr double kMostLasting = 4.0;
// Of an error of the way: what goes aside with it, and turns (per m), so that NEES is 1 on the
// whole over right cameras that had turned by up to 0.5 degrees.
constexpr double kAside = 0.045;
constexpr double kTurn_radpm = 0.0045;

// Of the motion (m, rad), for an error along the way.
Matrix6d doubt_of(const Eigen::Vector3d& error_m) {
  const Eigen::Matrix3d along_m2 = error_m * error_m.transpose();
  const Eigen::Matrix3d across_m2 = error_m.squaredNorm() * Eigen::Matrix3d::Identity() - along_m2;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = along_m2 + kAside * kAside * across_m2;
  covariance.bottomRightCorner<3, 3>() = kTurn_radpm * kTurn_radpm * across_m2;
  return covariance;
}

}  // namespace

// One pair tells it roughly, and what makes points err together, such as a rolling shutter or a
// wrong calibration, lasts.
void ErrorGrowth::note(double common_error, double dt_s) {
  pairs_ += 1.0;
  const double rate = std::max(1.0 - std::exp(-dt_s / kCommonErrorS), 1.0 / pairs_);
  common_error_ += rate * (common_error - common_error_);
}

double ErrorGrowth::share(std::span<const MapPoint> map, double dt_s) const {
  if (map.empty()) return common_error_;
  const auto is_new = [](const MapPoint& point) { return point.updates == 0; };
  const auto renewed = static_cast<double>(std::count_if(map.begin(), map.end(), is_new)) /
                       static_cast<double>(map.size());
  return common_error_ * std::min(kMostLasting, kLastingPerS * dt_s + kLastingOfNew * renewed);
}

const Vector6d& LastingError::add(const Vector6d& error,
                                  const Eigen::Isometry3d& T_previous_current, double dt_s) {
  second_ = std::exp(-dt_s) * adjoint(T_previous_current.inverse()) * second_ + error;
  return second_;
}

Matrix6d ScaleDoubt::note(const TrackSet& tracks, std::span<const Correspondence> seen,
                          const Eigen::Isometry3d& T_previous_current, double dt_s,
                          std::vector<double>& scratch) {
  sigma_ = 0.0;
  covariance_.setZero();
  if (!tracks.right_turn.is_off) return Matrix6d::Zero();
  scratch.clear();
  for (const Correspondence& c : seen) scratch.push_back(c.observed_px.z());
  const double disparity_px = std::max(median(scratch, 1.0), 1.0);
  sigma_ = tracks.camera.fx_px * tracks.right_turn.yaw_sigma_rad / disparity_px;
  Vector6d error = Vector6d::Zero();
  error.head<3>() =
      sigma_ * T_previous_current.linear().transpose() * T_previous_current.translation();
  covariance_ = doubt_of(error.head<3>());
  return dt_s * doubt_of(lasting_.add(error, T_previous_current, dt_s).head<3>());
}

}  // namespace egomod
