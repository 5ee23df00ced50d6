// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/manoeuvre.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr double kMemory_s = kUsualLag_s;
constexpr double kMostLag_s = 1.0;
constexpr double kLeadError = 0.6;  // of the steady lead
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

void Manoeuvre::follow(const BodyMotion& body, Nanoseconds now, const MotionStart& start) {
  const Eigen::Vector3d& velocity_mps = body.velocity_mps;
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
  lead_ = steady_lead(body);
}

void Manoeuvre::rotate(const Eigen::Matrix3d& R_to_from) {
  slow_mps_ = R_to_from * slow_mps_;
  change_mps_ = R_to_from * change_mps_;
  trend_mps_ = R_to_from * trend_mps_;
  unrest_m2ps2_ = R_to_from * unrest_m2ps2_ * R_to_from.transpose();
  lead_.axes = R_to_from * lead_.axes;
}

Eigen::Vector3d Manoeuvre::lead_mps() const { return kLeadShare * change_mps_; }

Eigen::Vector3d Manoeuvre::steady_lead_mps() const {
  return lead_.axes * (lead_.share * lead_.full_mps).matrix();
}

// The noise of a filtered velocity lasts as long as its lag: of the lead, which multiplies what
// changes in a shorter time, there is more the longer that is.
Manoeuvre::SteadyLead Manoeuvre::steady_lead(const BodyMotion& body) const {
  SteadyLead lead;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(body.lag_s);
  lead.axes = solver.eigenvectors();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = lead.axes.col(k);
    const double lag_s = std::clamp(solver.eigenvalues()[k], kMemory_s, kMostLag_s);
    const double trend_mps = axis.dot(trend_mps_);
    const double unrest_m2ps2 = axis.dot(unrest_m2ps2_ * axis);
    lead.full_mps[k] = lag_s / kMemory_s * trend_mps;
    lead.noise_m2ps2[k] =
        2.0 * lag_s / kUnrestMemory_s * axis.dot(body.velocity_covariance_m2ps2 * axis);
    const double square_m2ps2 = lead.full_mps[k] * lead.full_mps[k];
    if (square_m2ps2 <= lead.noise_m2ps2[k]) continue;
    const double goes_on =
        (trend_mps * trend_mps / unrest_m2ps2 - kTrendOfNoise) / (1.0 - kTrendOfNoise);
    lead.share[k] = std::clamp(goes_on, 0.0, 1.0) * (1.0 - lead.noise_m2ps2[k] / square_m2ps2);
  }
  return lead;
}

// What is led is no unrest any more, but the lead errs itself.
Eigen::Matrix3d Manoeuvre::covariance_m2ps2() const {
  const Eigen::Vector3d velocity_mps = slow_mps_ + change_mps_;
  const double age_s = to_seconds(now_ - begun_);
  const double behind = kBehind * kBehind * start_.stood_share * std::exp(-2.0 * age_s / kMemory_s);
  const Eigen::Vector3d led_mps =
      lead_.axes * lead_.share.matrix().asDiagonal() * lead_.axes.transpose() * trend_mps_;
  const auto square = [](const Eigen::Vector3d& x) -> Eigen::Matrix3d { return x * x.transpose(); };
  const Eigen::Matrix3d along = square(change_mps_ - led_mps) + unrest_m2ps2_ - square(trend_mps_) +
                                square(trend_mps_ - led_mps) + behind * square(velocity_mps);
  const Eigen::Array3d share = lead_.share;
  const Eigen::Vector3d of_lead =
      (share * (1.0 - share) + kLeadError * kLeadError * share.square()) * lead_.full_mps.square() +
      share.square() * lead_.noise_m2ps2;
  return kAlongShare * along + kAcrossShare * along.trace() * Eigen::Matrix3d::Identity() +
         lead_.axes * of_lead.asDiagonal() * lead_.axes.transpose();
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
