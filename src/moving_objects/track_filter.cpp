// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/track_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

// Share of the measurements that are outliers, anywhere in 1e6 px^3: logs of the densities.
constexpr double kLogInlier = -2.7770;    // log(0.98 / (2 pi)^(3/2))
constexpr double kLogOutlier = -17.7275;  // log(0.02 / 1e6)
constexpr double kNoOutlier = 12.0;       // above the outliers' by this, nothing is added
constexpr double kMostPerPair = 6.0;      // evidence: no single measurement convinces
constexpr double kCutChi2 = 25.0;         // from here on a measurement pulls less
constexpr double kMisfitMemory = 0.9;
constexpr double kMostMisfit = 50.0;  // of one measurement
constexpr double kFittingChi2 = 3.0;
constexpr double kMostAgility = 6.0;
constexpr double kFadePerS = 1.35;  // a standing point's certainty, for all that creeps
constexpr double kAccelerationTime_s = 1.0 / 30.0;  // how long an acceleration lasts
constexpr double kFresh_s = 2.0;
constexpr double kNearBound = 0.5;
constexpr double kSurpriseChi2 = 16.27;  // 99.9 %, 3 dof: foretold neither at rest nor as it was

struct Fit {
  double chi2 = 0.0;
  double log_likelihood = 0.0;
};

// Log of the sum of two densities, of which the second is the outliers'.
double with_outliers(double log_inlier) {
  const double above = log_inlier - kLogOutlier;
  if (above > kNoOutlier) return log_inlier;
  return kLogOutlier + std::log1p(std::exp(above));
}

// C -= K A^T, known to be symmetric: rounding would grow, since the next update multiplies it.
template <int N>
void subtract_symmetric(const Eigen::Matrix<double, N, 3>& K, const Eigen::Matrix<double, N, 3>& A,
                        Eigen::Matrix<double, N, N>& C) {
  for (int row = 0; row < N; ++row) {
    for (int k = 0; k <= row; ++k) {
      C(row, k) -= K(row, 0) * A(k, 0) + K(row, 1) * A(k, 1) + K(row, 2) * A(k, 2);
      C(k, row) = C(row, k);
    }
  }
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
  Eigen::Matrix3d S_inverse;
  double determinant = 0.0;
  bool invertible = false;
  S.computeInverseAndDetWithCheck(S_inverse, determinant, invertible, 0.0);
  if (!(determinant > 0.0) || !std::isfinite(determinant)) return {};
  Fit fit;
  fit.chi2 = r.dot(S_inverse * r);
  if (!std::isfinite(fit.chi2)) return {};
  const double cut = std::min(1.0, kCutChi2 / std::max(fit.chi2, 1e-12));
  const Eigen::Matrix<double, N, 3> K = A * (cut * S_inverse);
  model.state.noalias() += K * r;
  subtract_symmetric<N>(K, A, model.covariance);
  model.bias_covariance.noalias() -= K * (c + z.bias_m);
  fit.log_likelihood = with_outliers(
      kLogInlier - 0.5 * (fit.chi2 + std::log(determinant / (z.volume_m3 * z.volume_m3))));
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

// The moving model forgets where the point was, too: how long ago it began to move is not known.
void move_from_here(TrackFilter& f, const PointMeasurement& measurement, const MotionPrior& prior) {
  f.moving.state << measurement.position_m, Eigen::Vector3d::Zero();
  f.moving.covariance.setZero();
  f.moving.covariance.topLeftCorner<3, 3>() =
      measurement.covariance_m2 + measurement.bias_m * measurement.bias_m.transpose();
  f.moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  f.moving.bias_covariance << -measurement.bias_m, Eigen::Vector3d::Zero();
  f.misfit = kFittingChi2;
  f.fresh = f.seen;
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
  // What starts after a rest: the velocity learnt at rest would resist for as long as it was
  // learnt.
  if (evidence < 0.0 && !is_young() && std::min(moves.chi2, stands.chi2) > kSurpriseChi2) {
    move_from_here(*this, measurement, prior);
  }
  if (evidence > kMostEvidence - kNearBound) stand_where_it_is(*this);
  if (misfit > 4.0 * kFittingChi2) {  // fits neither: a mismatch, or another surface
    evidence = std::min(evidence, 0.0);
    if (misfit > 8.0 * kFittingChi2) start(measurement, prior, seen);
  }
}

}  // namespace egomod
