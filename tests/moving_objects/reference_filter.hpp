// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/core/time.hpp"
#include "moving_objects/filter_kernels.hpp"
#include "moving_objects/rig_pose.hpp"

// What the filters' kernels compute, one point at a time and in Eigen's words.
namespace egomod::reference {

// One pair's view of a point, in the first camera's axes, linearised where `measure` was told.
struct PointMeasurement {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  // of this pair alone
  Eigen::Matrix3d walk_m2 = Eigen::Matrix3d::Zero();        // what the track strays between pairs
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();  // one sigma of the point's constant error
  double volume_m3 = 1.0;                            // of one px^3
};

// Position, or position and velocity, of a point whose disparity has an unknown constant error b:
// b is considered, not estimated (S. Schmidt's filter), as one sigma of it.
template <int N>
struct PointModel {
  Eigen::Matrix<double, N, 1> state = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> bias_covariance = Eigen::Matrix<double, N, 1>::Zero();
};

struct Fit {
  double chi2 = 0.0;
  double log_likelihood = 0.0;
};

struct TrackFilter {
  PointModel<3> standing;
  PointModel<6> moving;
  double evidence = 0.0;
  double misfit = 0.0;
  int updates = 0;
  double standing_chi2 = 0.0;
  Nanoseconds seen{0};
  double interval_s = 0.0;  // before that
  Nanoseconds fresh{0};
  bool stood = false;
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();

  void start(const PointMeasurement& measurement, const MotionPrior& prior, Nanoseconds now);
  void predict(const MotionPrior& prior, Nanoseconds now);
  void update(const PointMeasurement& measurement, const MotionPrior& prior, bool is_slow);
  void start_in_between(const PointMeasurement& measurement, const MotionPrior& prior,
                        const PointModel<3>& rested, const Fit& stands);

  [[nodiscard]] Eigen::Vector3d position_m() const { return moving.state.head<3>(); }
  [[nodiscard]] Eigen::Vector3d velocity_mps() const { return moving.state.tail<3>(); }
};

// Share of the measurements that are outliers, anywhere in 1e6 px^3: logs of the densities.
inline constexpr double kLogInlier = -2.7770;    // log(0.98 / (2 pi)^(3/2))
inline constexpr double kLogOutlier = -17.7275;  // log(0.02 / 1e6)
inline constexpr double kNoOutlier = 12.0;       // above the outliers' by this, nothing is added
inline constexpr double kMostPerPair = 6.0;      // evidence: no single measurement convinces
inline constexpr double kCutChi2 = 25.0;         // from here on a measurement pulls less
inline constexpr double kMisfitMemory = 0.9;
inline constexpr double kMostMisfit = 50.0;  // of one measurement
inline constexpr double kFittingChi2 = 3.0;
inline constexpr double kMostAgility = 6.0;
inline constexpr double kFadePerS = 1.35;  // a standing point's certainty, for all that creeps
inline constexpr double kAccelerationTime_s = 1.0 / 30.0;  // how long an acceleration lasts
inline constexpr double kFresh_s = 2.0;
inline constexpr double kNearBound = 0.5;
inline constexpr double kStoodEvidence = 0.5 * kLeastEvidence;
inline constexpr double kSurpriseChi2 = 16.27;

// Log of the sum of two densities, of which the second is the outliers'.
inline double with_outliers(double log_inlier) {
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

inline void learn_velocity_anew(TrackFilter& f, const MotionPrior& prior, Nanoseconds now) {
  f.moving.state << f.standing.state, Eigen::Vector3d::Zero();
  f.moving.covariance.setZero();
  f.moving.covariance.topLeftCorner<3, 3>() = f.standing.covariance;
  f.moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  f.moving.bias_covariance << f.standing.bias_covariance, Eigen::Vector3d::Zero();
  f.misfit = kFittingChi2;
  f.fresh = now;
  f.stood = false;
}

inline void move_from_here(TrackFilter& f, const PointMeasurement& measurement,
                           const MotionPrior& prior) {
  f.moving.state << measurement.position_m, Eigen::Vector3d::Zero();
  f.moving.covariance.setZero();
  f.moving.covariance.topLeftCorner<3, 3>() =
      measurement.covariance_m2 + measurement.bias_m * measurement.bias_m.transpose();
  f.moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  f.moving.bias_covariance << -measurement.bias_m, Eigen::Vector3d::Zero();
  f.evidence = 0.0;
  f.misfit = kFittingChi2;
  f.fresh = f.seen;
  f.stood = false;
}

inline void stand_where_it_is(TrackFilter& f) {
  f.standing.state = f.moving.state.head<3>();
  f.standing.covariance = f.moving.covariance.topLeftCorner<3, 3>();
  f.standing.bias_covariance = f.moving.bias_covariance.head<3>();
}

inline void TrackFilter::start(const PointMeasurement& measurement, const MotionPrior& prior,
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

inline void predict_moving(const MotionPrior& prior, double agility, double dt,
                           PointModel<6>& moving) {
  const Eigen::Vector3d velocity_mps = moving.state.tail<3>();
  const double a = agility * (prior.acceleration_mps2 + prior.manoeuvre_hz * velocity_mps.norm());
  const double q = a * a * kAccelerationTime_s * dt;
  moving.state.head<3>() += dt * velocity_mps;
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
}

inline void TrackFilter::predict(const MotionPrior& prior, Nanoseconds now) {
  interval_s = to_seconds(now - seen);
  seen = now;
  if (updates == 1) {  // the rig's own speed, and with it the prior, may not have been known then
    moving.covariance.diagonal().tail<3>().setConstant(prior.velocity_mps * prior.velocity_mps);
  }
  standing.covariance *= 1.0 + (kFadePerS - 1.0) * interval_s;
  // A manoeuvre shows as misfit before it shows in the velocity.
  predict_moving(prior, std::clamp(misfit / kFittingChi2, 1.0, kMostAgility), interval_s, moving);

  // A start and a stop are seen against a fresh opponent only: a velocity learnt at rest resists
  // the one, a place left long ago the other.
  if (evidence < kLeastEvidence + kNearBound && to_seconds(now - fresh) > kFresh_s) {
    learn_velocity_anew(*this, prior, now);
  }
}

// A long interval shows by itself what left its place in it.
inline void TrackFilter::start_in_between(const PointMeasurement& measurement,
                                          const MotionPrior& prior, const PointModel<3>& rested,
                                          const Fit& stands) {
  TrackFilter left;
  left.standing = rested;
  learn_velocity_anew(left, prior, seen);
  predict_moving(prior, 1.0, interval_s, left.moving);
  const Fit leaves = fuse(measurement, left.moving);
  if (leaves.chi2 >= kSurpriseChi2) return;
  moving = left.moving;
  misfit = kFittingChi2;
  fresh = seen;
  stood = false;
  evidence = std::clamp(leaves.log_likelihood - stands.log_likelihood, 0.0, kMostPerPair);
}

inline void TrackFilter::update(const PointMeasurement& measurement, const MotionPrior& prior,
                                bool is_slow) {
  standing.covariance += measurement.walk_m2;
  moving.covariance.topLeftCorner<3, 3>() += measurement.walk_m2;
  const PointModel<3> rested = standing;
  const Fit moves = fuse(measurement, moving);
  const Fit stands = fuse(measurement, standing);
  const double gain = moves.log_likelihood - stands.log_likelihood;
  evidence = std::clamp(evidence + std::clamp(gain, -kMostPerPair, kMostPerPair), kLeastEvidence,
                        kMostEvidence);
  standing_chi2 = stands.chi2;
  misfit += (1.0 - kMisfitMemory) * (std::min(moves.chi2, kMostMisfit) - misfit);
  ++updates;
  stood = stood || evidence < kStoodEvidence;
  if (evidence < 0.0 && updates >= 3 && stands.chi2 > kSurpriseChi2) {
    if (moves.chi2 > kSurpriseChi2) move_from_here(*this, measurement, prior);
    if (is_slow) start_in_between(measurement, prior, rested, stands);
  }
  if (evidence > kMostEvidence - kNearBound) stand_where_it_is(*this);
  if (misfit > 4.0 * kFittingChi2) {  // fits neither: a mismatch, or another surface
    evidence = std::min(evidence, 0.0);
    if (misfit > 8.0 * kFittingChi2) start(measurement, prior, seen);
  }
}

struct Camera {
  StereoCamera camera;
  RigPose rig;
  double disparity_bias_px = 0.0, flow_error_share = 0.0, walk_px = 0.0;
  bool is_slow = false;
};

// C of a point at this offset from the camera, both in the first camera's axes: T * Exp(xi) moves
// it by R (rho + phi x P) = rho' - [offset]x phi'.
inline Eigen::Matrix3d covariance_at(const RigPose& rig, const Eigen::Vector3d& offset_m) {
  const Eigen::Matrix3d S = skew(offset_m);
  const Eigen::Matrix3d CS = rig.cross_covariance * S;
  return rig.translation_covariance + CS + CS.transpose() - S * rig.rotation_covariance * S;
}

inline Eigen::Vector3d expected_px(const Camera& c, const TrackFilter& filter,
                                   const Eigen::Vector3d& measured_px) {
  if (filter.updates < 3) return measured_px;
  const Eigen::Vector3d P_m = c.rig.T_current_first * filter.position_m();
  const double share = c.camera.fx_px * c.camera.baseline_m / P_m.z() / measured_px.z();
  return share < 0.5 || share > 2.0 ? measured_px : project(c.camera, P_m);
}

inline PointMeasurement measure(const Camera& c, const Eigen::Vector3d& z_px,
                                const Eigen::Matrix3d& R_px2, double reanchored_px,
                                const TrackFilter& filter) {
  const Eigen::Vector3d at_px = expected_px(c, filter, z_px);
  const Eigen::Matrix3d J = triangulate_jacobian(c.camera, at_px);
  const Eigen::Matrix3d G = c.rig.T_first_current.linear() * J;
  const double path_px = filter.updates > 0 ? (z_px - filter.uvd_px).norm() : 0.0;
  const double stretch_px = c.flow_error_share * path_px;
  const double wander_px = std::hypot(c.walk_px, stretch_px) + reanchored_px;
  PointMeasurement m;
  m.position_m = c.rig.T_first_current * triangulate(c.camera, at_px);
  m.covariance_m2 = G * R_px2 * G.transpose() +
                    covariance_at(c.rig, m.position_m - c.rig.T_first_current.translation());
  m.position_m += G * (z_px - at_px);
  const Eigen::Vector3d walk_px2{wander_px * wander_px, wander_px * wander_px,
                                 stretch_px * stretch_px};
  m.walk_m2 = G * walk_px2.asDiagonal() * G.transpose();
  m.bias_m = c.disparity_bias_px * G.col(2);
  m.volume_m3 = std::abs(J.determinant());
  return m;
}

inline void step(const Camera& c, const MotionPrior& prior, Nanoseconds now,
                 const Eigen::Vector3d& z_px, const Eigen::Matrix3d& R_px2, double reanchored_px,
                 TrackFilter& filter) {
  const bool is_new = filter.updates == 0;
  if (!is_new) filter.predict(prior, now);
  const PointMeasurement measurement = measure(c, z_px, R_px2, reanchored_px, filter);
  if (is_new) {
    filter.start(measurement, prior, now);
  } else {
    filter.update(measurement, prior, c.is_slow);
  }
  filter.uvd_px = z_px;
}

}  // namespace egomod::reference
