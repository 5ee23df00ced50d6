// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/track_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr double kLog2Pi3_2 = 2.7568;   // log (2 pi)^(3/2)
constexpr double kOutlierShare = 0.02;  // of the measurements, anywhere in...
constexpr double kSearchVolume_px3 = 1e6;
constexpr double kMostPerPair = 6.0;  // evidence: no single measurement convinces
constexpr double kCutChi2 = 25.0;     // from here on a measurement pulls less
constexpr double kMisfitMemory = 0.9;
constexpr double kMostMisfit = 50.0;  // of one measurement
constexpr double kFittingChi2 = 3.0;
constexpr double kMostAgility = 6.0;
constexpr double kFadePerS = 1.35;  // a standing point's certainty, for all that creeps
constexpr double kAccelerationTime_s = 1.0 / 30.0;  // how long an acceleration lasts
constexpr double kFresh_s = 2.0;
constexpr double kNearBound = 0.5;

struct Fit {
  double chi2 = 0.0;
  double log_likelihood = 0.0;
};

double log_of_sum(double a, double b) {
  return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b)));
}

template <int N>
Fit fuse(const PointMeasurement& z, PointModel<N>& model) {
  const Eigen::Vector3d r = z.position_m - model.state.template head<3>();
  const Eigen::Vector3d c = model.bias_covariance.template head<3>();
  // Covariance of state and innovation; the innovation is (x - x^) + bias b + noise.
  Eigen::Matrix<double, N, 3> A = model.covariance.template leftCols<3>();
  A.noalias() += model.bias_covariance * z.bias_m.transpose();
  Eigen::Matrix3d S = A.template topRows<3>() + z.covariance_m2;
  S.noalias() += z.bias_m * (c + z.bias_m).transpose();
  const double determinant = S.determinant();
  if (!(determinant > 0.0) || !std::isfinite(determinant)) return {};
  const Eigen::Matrix3d S_inverse = S.inverse();
  Fit fit;
  fit.chi2 = r.dot(S_inverse * r);
  if (!std::isfinite(fit.chi2)) return {};
  const double cut = std::min(1.0, kCutChi2 / std::max(fit.chi2, 1e-12));
  const Eigen::Matrix<double, N, 3> K = cut * (A * S_inverse);
  model.state.noalias() += K * r;
  const Eigen::Matrix<double, N, N> C = model.covariance - K * A.transpose();
  // Rounding would grow: the next update multiplies what is not symmetric.
  model.covariance = 0.5 * (C + C.transpose());
  model.bias_covariance.noalias() -= K * (c + z.bias_m);
  fit.log_likelihood = log_of_sum(std::log1p(-kOutlierShare) - kLog2Pi3_2 + z.log_volume -
                                      0.5 * (fit.chi2 + std::log(determinant)),
                                  std::log(kOutlierShare / kSearchVolume_px3));
  return fit;
}

void learn_velocity_anew(TrackFilter& f, const MotionPrior& prior, Nanoseconds now) {
  f.moving.state << f.standing.state, Eigen::Vector3d::Zero();
  f.moving.covariance.setZero();
  f.moving.covariance.topLeftCorner<3, 3>() = f.standing.covariance;
  f.moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  f.moving.bias_covariance << f.standing.bias_covariance, Eigen::Vector3d::Zero();
  f.misfit = kFittingChi2;
  f.fresh = now;
}

void stand_where_it_is(TrackFilter& f) {
  f.standing.state = f.moving.state.head<3>();
  f.standing.covariance = f.moving.covariance.topLeftCorner<3, 3>();
  f.standing.bias_covariance = f.moving.bias_covariance.head<3>();
}

}  // namespace

void TrackFilter::start(const PointMeasurement& measurement, const MotionPrior& prior,
                        Nanoseconds now) {
  standing.state = measurement.position_m;
  standing.covariance =
      measurement.covariance_m2 + measurement.bias_m * measurement.bias_m.transpose();
  standing.bias_covariance = -measurement.bias_m;
  learn_velocity_anew(*this, prior, now);
  evidence = 0.0;
  updates = 1;
  seen = now;
}

void TrackFilter::predict(const MotionPrior& prior, Nanoseconds now) {
  const double dt = to_seconds(now - seen);
  seen = now;
  if (updates == 1) {  // the rig's own speed, and with it the prior, may not have been known then
    moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  }
  standing.covariance *= 1.0 + (kFadePerS - 1.0) * dt;
  // A manoeuvre shows as misfit before it shows in the velocity.
  const double agility = std::clamp(misfit / kFittingChi2, 1.0, kMostAgility);
  const double a = agility * (prior.acceleration_mps2 + prior.manoeuvre_hz * velocity_mps().norm());
  const double q = a * a * kAccelerationTime_s * dt;
  moving.state.head<3>() += dt * velocity_mps();
  Eigen::Matrix<double, 6, 6>& C = moving.covariance;
  const Eigen::Matrix3d moved = dt * C.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d cross = dt * C.topRightCorner<3, 3>();
  C.topLeftCorner<3, 3>() += cross + cross.transpose() + dt * moved;
  C.topRightCorner<3, 3>() += moved;
  C.bottomLeftCorner<3, 3>() = C.topRightCorner<3, 3>().transpose();
  moving.bias_covariance.head<3>() += dt * moving.bias_covariance.tail<3>();
  C.diagonal().head<3>().array() += q * dt * dt / 3.0;
  C.diagonal().tail<3>().array() += q;
  C.topRightCorner<3, 3>().diagonal().array() += 0.5 * q * dt;
  C.bottomLeftCorner<3, 3>().diagonal().array() += 0.5 * q * dt;

  // A start and a stop are seen against a fresh opponent only: a velocity learnt at rest resists
  // the one, a place left long ago the other.
  if (evidence < kLeastEvidence + kNearBound && to_seconds(now - fresh) > kFresh_s) {
    learn_velocity_anew(*this, prior, now);
  }
}

void TrackFilter::update(const PointMeasurement& measurement, const MotionPrior& prior) {
  standing.covariance += measurement.walk_m2;
  moving.covariance.topLeftCorner<3, 3>() += measurement.walk_m2;
  const Fit moves = fuse(measurement, moving);
  const Fit stands = fuse(measurement, standing);
  const double gain = moves.log_likelihood - stands.log_likelihood;
  evidence = std::clamp(evidence + std::clamp(gain, -kMostPerPair, kMostPerPair), kLeastEvidence,
                        kMostEvidence);
  standing_chi2 = stands.chi2;
  misfit += (1.0 - kMisfitMemory) * (std::min(moves.chi2, kMostMisfit) - misfit);
  ++updates;
  if (evidence > kMostEvidence - kNearBound) stand_where_it_is(*this);
  if (misfit > 4.0 * kFittingChi2) {  // fits neither: a mismatch, or another surface
    evidence = std::min(evidence, 0.0);
    if (misfit > 8.0 * kFittingChi2) start(measurement, prior, seen);
  }
}

}  // namespace egomod
