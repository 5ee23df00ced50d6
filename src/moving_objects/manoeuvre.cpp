// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/manoeuvre.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr double kMemory_s = kUsualLag_s;
constexpr double kMostLag_s = 1.0;
constexpr double kSettling = 4.0;  // lags: what has just set off is being learnt, which is no trend
constexpr double kAlikeLags = 1.2;
constexpr double kLeadError = 0.6;    // of the steady lead
constexpr double kUnseenShare = 0.5;  // of what the noise leaves open, as a variance
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
  lead_.mps = R_to_from * lead_.mps;
  lead_.of_trend_mps = R_to_from * lead_.of_trend_mps;
  lead_.covariance_m2ps2 = R_to_from * lead_.covariance_m2ps2 * R_to_from.transpose();
}

Eigen::Vector3d Manoeuvre::lead_mps() const { return kLeadShare * change_mps_; }

Eigen::Vector3d Manoeuvre::steady_lead_mps() const { return lead_.mps; }

// Far away the lag is long along the line of sight: that axis by itself, where it stands out.
Manoeuvre::SteadyLead Manoeuvre::steady_lead(const BodyMotion& body) const {
  SteadyLead lead;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(body.lag_s);  // ascending
  const Eigen::Array3d lags_s = solver.eigenvalues().array().max(kMemory_s).min(kMostLag_s);
  const Eigen::Vector3d longest = solver.eigenvectors().col(2);
  const double others_s = 0.5 * (lags_s[0] + lags_s[1]);
  const Eigen::Matrix3d all = Eigen::Matrix3d::Identity();
  if (lags_s[2] < kAlikeLags * others_s) {
    lead_along(body, all, lags_s.mean(), lead);
  } else {
    const Eigen::Matrix3d onto = longest * longest.transpose();
    lead_along(body, onto, lags_s[2], lead);
    lead_along(body, all - onto, others_s, lead);
  }
  return lead;
}

// The noise of a filtered velocity lasts as long as its lag: of the lead, which multiplies what
// changes in a shorter time, there is more the longer that is.
void Manoeuvre::lead_along(const BodyMotion& body, const Eigen::Matrix3d& onto, double lag_s,
                           SteadyLead& lead) const {
  const Eigen::Vector3d trend_mps = onto * trend_mps_;
  const Eigen::Vector3d full_mps = lag_s / kMemory_s * trend_mps;
  const Eigen::Matrix3d noise_m2ps2 =
      2.0 * lag_s / kUnrestMemory_s * onto * body.velocity_covariance_m2ps2 * onto;
  const double full2 = full_mps.squaredNorm();
  if (!(full2 > 0.0)) return;
  const double noise_share = std::min(1.0, noise_m2ps2.trace() / full2);
  const double unrest_m2ps2 = (onto * unrest_m2ps2_ * onto).trace();
  const double goes_on =
      (trend_mps.squaredNorm() / unrest_m2ps2 - kTrendOfNoise) / (1.0 - kTrendOfNoise);
  const double age_s = to_seconds(now_ - begun_);
  const double settled = 1.0 - start_.stood_share * std::exp(-age_s / (kSettling * lag_s));
  const double share = settled * std::clamp(goes_on, 0.0, 1.0) * (1.0 - noise_share);
  const double left = 1.0 - share;
  lead.mps += share * full_mps;
  lead.of_trend_mps += share * trend_mps;
  lead.covariance_m2ps2 += (share * left + kUnseenShare * left * left * noise_share +
                            kLeadError * kLeadError * share * share) *
                               full_mps * full_mps.transpose() +
                           share * share * noise_m2ps2;
}

// What is led is no unrest any more, but the lead errs itself.
Eigen::Matrix3d Manoeuvre::covariance_m2ps2() const {
  const Eigen::Vector3d velocity_mps = slow_mps_ + change_mps_;
  const double age_s = to_seconds(now_ - begun_);
  const double behind = kBehind * kBehind * start_.stood_share * std::exp(-2.0 * age_s / kMemory_s);
  const auto square = [](const Eigen::Vector3d& x) -> Eigen::Matrix3d { return x * x.transpose(); };
  const Eigen::Matrix3d along = square(change_mps_ - lead_.of_trend_mps) + unrest_m2ps2_ -
                                square(trend_mps_) + square(trend_mps_ - lead_.of_trend_mps) +
                                behind * square(velocity_mps);
  const double across_m2ps2 =
      kAcrossShare * (along.trace() + lead_.covariance_m2ps2.trace() / kAlongShare);
  return kAlongShare * along + lead_.covariance_m2ps2 + across_m2ps2 * Eigen::Matrix3d::Identity();
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
