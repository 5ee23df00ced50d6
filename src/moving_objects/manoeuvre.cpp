// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/manoeuvre.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr double kMemory_s = 0.15;  // about what a point's filter lags behind
constexpr double kUnrestMemory_s = 0.5;
// Of the mean squares of changes: what is left of the error along them, and what there is of it in
// any direction, since a point's depth and its way across the image are measured together.
constexpr double kAlongShare = 0.7;
constexpr double kAcrossShare = 0.04;
constexpr double kLeadShare = 0.3;  // of the change: more of it adds more noise than it takes lag
// Of the mean square of changes, their mean's square has this share where they are noise.
constexpr double kTrendOfNoise = 0.3;

// Of the velocity of what stood: by so much it may be behind when it first shows.
constexpr double kBehind = 2.0;
constexpr double kStart_s = 0.3;  // about what it takes to get there
constexpr double kPast_s = 0.5;
constexpr double kAgeing = 2.0;  // in the time that it took

}  // namespace

void Manoeuvre::follow(const Eigen::Vector3d& velocity_mps, Nanoseconds now,
                       const MotionStart& start) {
  const bool anew = now_ < Nanoseconds{0} || to_seconds(now - now_) > kUnrestMemory_s;
  const double elapsed_s = anew ? 0.0 : to_seconds(now - now_);
  now_ = now;
  if (anew) {
    begun_ = now;
    start_ = start;
    slow_mps_ = velocity_mps;
    trend_mps_.setZero();
  }
  slow_mps_ -= std::expm1(-elapsed_s / kMemory_s) * (velocity_mps - slow_mps_);
  change_mps_ = velocity_mps - slow_mps_;
  trend_mps_ -= std::expm1(-elapsed_s / kUnrestMemory_s) * (change_mps_ - trend_mps_);
  unrest_m2ps2_ -= std::expm1(-elapsed_s / kUnrestMemory_s) *
                   (change_mps_ * change_mps_.transpose() - unrest_m2ps2_);
}

void Manoeuvre::rotate(const Eigen::Matrix3d& R_to_from) {
  slow_mps_ = R_to_from * slow_mps_;
  change_mps_ = R_to_from * change_mps_;
  trend_mps_ = R_to_from * trend_mps_;
  unrest_m2ps2_ = R_to_from * unrest_m2ps2_ * R_to_from.transpose();
}

Eigen::Vector3d Manoeuvre::lead_mps() const { return kLeadShare * change_mps_; }

Eigen::Vector3d Manoeuvre::steady_lead_mps() const {
  const double unrest_m2ps2 = unrest_m2ps2_.trace();
  if (unrest_m2ps2 <= 0.0) return Eigen::Vector3d::Zero();
  const double share = trend_mps_.squaredNorm() / unrest_m2ps2;
  return std::clamp((share - kTrendOfNoise) / (1.0 - kTrendOfNoise), 0.0, 1.0) * trend_mps_;
}

Eigen::Matrix3d Manoeuvre::covariance_m2ps2() const {
  const Eigen::Vector3d velocity_mps = slow_mps_ + change_mps_;
  const double age_s = to_seconds(now_ - begun_);
  const double behind = kBehind * kBehind * start_.stood_share * std::exp(-2.0 * age_s / kMemory_s);
  const Eigen::Matrix3d along = change_mps_ * change_mps_.transpose() + unrest_m2ps2_ +
                                behind * velocity_mps * velocity_mps.transpose();
  return kAlongShare * along + kAcrossShare * along.trace() * Eigen::Matrix3d::Identity();
}

// What stood has come to its velocity since, from nothing.
Eigen::Matrix3d Manoeuvre::acceleration_m2ps4() const {
  const Eigen::Vector3d velocity_mps = slow_mps_ + change_mps_;
  const double age_s = to_seconds(now_ - begun_);
  const double start = start_.stood_share * std::exp(-2.0 * age_s / kMemory_s);
  return change_mps_ * change_mps_.transpose() / (kMemory_s * kMemory_s) +
         start / (kStart_s * kStart_s) * velocity_mps * velocity_mps.transpose();
}

double Manoeuvre::behind_share() const {
  return start_.stood_share * std::exp(-to_seconds(now_ - begun_) / kStart_s);
}

bool Manoeuvre::has_past() const {
  return start_.stood_share > 0.5 || to_seconds(now_ - begun_) + start_.learnt_s > kPast_s;
}

double Manoeuvre::youth() const {
  const double age_s = to_seconds(now_ - begun_);
  return start_.learnt_s > 0.0 ? std::exp(-kAgeing * age_s / start_.learnt_s) : 0.0;
}

}  // namespace egomod
