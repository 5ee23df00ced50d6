// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/manoeuvre.hpp"

#include <cmath>

namespace egomod {
namespace {

constexpr double kMemory_s = 0.15;  // about what a point's filter lags behind
constexpr double kUnrestMemory_s = 0.5;
// Of the mean squares of changes: what is left of the error along them, and what there is of it in
// any direction, since a point's depth and its way across the image are measured together.
constexpr double kAlongShare = 0.7;
constexpr double kAcrossShare = 0.1;
constexpr double kLeadShare = 0.3;  // of the change: more of it adds more noise than it takes lag

}  // namespace

void Manoeuvre::follow(const Eigen::Vector3d& velocity_mps, Nanoseconds now) {
  const bool first = now_ < Nanoseconds{0};
  const double elapsed_s = first ? 0.0 : to_seconds(now - now_);
  now_ = now;
  if (first) slow_mps_ = velocity_mps;
  slow_mps_ -= std::expm1(-elapsed_s / kMemory_s) * (velocity_mps - slow_mps_);
  change_mps_ = velocity_mps - slow_mps_;
  unrest_m2ps2_ -= std::expm1(-elapsed_s / kUnrestMemory_s) *
                   (change_mps_ * change_mps_.transpose() - unrest_m2ps2_);
}

void Manoeuvre::rotate(const Eigen::Matrix3d& R_to_from) {
  slow_mps_ = R_to_from * slow_mps_;
  change_mps_ = R_to_from * change_mps_;
  unrest_m2ps2_ = R_to_from * unrest_m2ps2_ * R_to_from.transpose();
}

Eigen::Vector3d Manoeuvre::lead_mps() const { return kLeadShare * change_mps_; }

Eigen::Matrix3d Manoeuvre::covariance_m2ps2() const {
  const Eigen::Matrix3d along = change_mps_ * change_mps_.transpose() + unrest_m2ps2_;
  return kAlongShare * along + kAcrossShare * along.trace() * Eigen::Matrix3d::Identity();
}

}  // namespace egomod
