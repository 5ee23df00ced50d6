// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/readout.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/robust_gauss_newton.hpp"
#include "egomod/egomotion/track_map.hpp"

namespace egomod {
namespace {

// Wide: before the readout is known, the rows that tell it most look like outliers.
constexpr double kMaxDistance2 = 50.0;
constexpr double kKernel = 24.0;
constexpr std::size_t kStride = 3;      // a third of the points tell enough
constexpr double kTrustedWeight = 0.5;  // static weight
constexpr double kPriorSigmaS = 0.01;
// What was learnt while little was known fades: memory grows with the time that has been learnt
// from.
constexpr double kMemoryShare = 0.3;
constexpr double kLeastMemoryS = 0.5;
constexpr double kMostMemoryS = 10.0;
// Global shutters seem to have a readout of some tenths of a millisecond.
constexpr double kLeastReadoutS = 2e-3;
constexpr double kSureSigmas = 4.0;
constexpr double kLeastFormalSigmas = 3.0;  // a track's errors last for some pairs
constexpr double kSettledS = 2.0;
constexpr double kToKeep = 0.5;  // of both
// A turn that sets off or ends at once is no line through three pairs.
constexpr double kJerkRadps = 0.1;
// The velocity between pairs is a line only nearly.
constexpr double kModelError = 0.07;  // of the readout

// What of two slopes they have in common (minmod of P. L. Roe, 1986).
double of_both(double a, double b) {
  return a * b <= 0.0 ? 0.0 : std::copysign(std::min(std::abs(a), std::abs(b)), a);
}

}  // namespace

void PairVelocity::keep(const Vector6d& mean_velocity) {
  kept_[1] = kept_[0];
  kept_[0] = mean_velocity;
  count_ = std::min(count_ + 1, kept_.size());
}

Vector6d PairVelocity::after(const Vector6d& mean_velocity) const {
  if (count_ == 0) return mean_velocity;
  if (count_ == 1) return 1.5 * mean_velocity - 0.5 * kept_[0];
  const Vector6d last = mean_velocity - kept_[0];
  const Vector6d before = kept_[0] - kept_[1];
  if ((last - before).tail<3>().norm() > kJerkRadps)
    return mean_velocity + 0.5 * last.binaryExpr(before, &of_both);
  return (13.0 * mean_velocity + 4.0 * kept_[0] - 5.0 * kept_[1]) / 12.0;
}

void ReadoutLearner::learn(const StereoCamera& camera,
                           std::span<const Correspondence> correspondences,
                           std::span<const double> distances2, std::span<const MapPoint> map,
                           const Eigen::Isometry3d& T_previous_current,
                           const Eigen::Isometry3d& T_first_current, const Vector6d& velocity,
                           double dt_s, bool is_told) {
  const Eigen::Isometry3d T = T_previous_current.inverse();
  const Eigen::Matrix3d R_current_first = T_first_current.linear().transpose();
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  Vector6d coupling = Vector6d::Zero();
  double own = 0.0;
  double pull = 0.0;
  for (std::size_t k = 0; k < correspondences.size(); k += kStride) {
    const Correspondence& c = correspondences[k];
    const Eigen::Vector3d P = T * c.P_previous_m;
    if (distances2[k] > kMaxDistance2 || c.static_weight < kTrustedWeight || P.z() < kMinDepthM)
      continue;
    const Eigen::Matrix<double, 3, 6> J = motion_jacobian(camera, P);
    const Eigen::Matrix3d H = project_jacobian(camera, P);
    const Eigen::Matrix3d H_previous = H * T.linear();
    const Eigen::Vector3d g = row_displacement_per_s(camera, P, velocity) -
                              H * (R_current_first * map[c.track].row_error_m_per_s);
    const Eigen::Matrix3d S =
        c.covariance_observed_px2 + H_previous * c.covariance_previous_m2 * H_previous.transpose();
    const double share = 1 / (1 + distances2[k] / kKernel);
    const Eigen::Matrix3d W = c.static_weight * share * share * S.inverse();
    const Eigen::Vector3d Wg = W * g;
    const Eigen::Vector3d r = c.observed_px - project(camera, P);
    const Eigen::Matrix<double, 6, 3> JW = J.transpose() * W;
    A += JW * J;
    b += JW * r;
    coupling += J.transpose() * Wg;
    own += g.dot(Wg);
    pull += r.dot(Wg);
  }
  const Eigen::LDLT<Matrix6d> ldlt(A);
  motion_error_per_s_ = ldlt.solve(coupling);
  const double information = std::max(0.0, own - coupling.dot(motion_error_per_s_));
  change_s_ = 0.0;
  if (ldlt.info() != Eigen::Success || !motion_error_per_s_.allFinite()) {
    motion_error_per_s_.setZero();
    return;
  }
  if (!is_told) return;
  age_s_ += dt_s;
  const double keep =
      std::exp(-dt_s / std::clamp(kMemoryShare * age_s_, kLeastMemoryS, kMostMemoryS));
  const double pull_in_all = pull - b.dot(motion_error_per_s_) + information * readout_s_;
  const double surprise = pull_in_all - information * estimate_s_;
  information_ = keep * information_ + information;
  pull_ = keep * pull_ + pull_in_all;
  scatter_ = keep * scatter_ + surprise * surprise;
  estimate_s_ = pull_ / (information_ + 1 / (kPriorSigmaS * kPriorSigmaS));
  decide();
}

double ReadoutLearner::sigma_s() const {
  if (!(information_ > 0.0)) return kPriorSigmaS;
  return std::max(std::sqrt(scatter_) / information_, kLeastFormalSigmas / std::sqrt(information_));
}

double ReadoutLearner::variance_s2() const {
  const double sigma = sigma_s();
  const double model = kModelError * readout_s_;
  return sigma * sigma + model * model;
}

void ReadoutLearner::decide() {
  const double before = readout_s_;
  const double asked = before > 0.0 ? kToKeep : 1.0;
  const bool sure = estimate_s_ > asked * std::max(kLeastReadoutS, kSureSigmas * sigma_s());
  readout_s_ = sure ? estimate_s_ : 0.0;
  change_s_ = readout_s_ - before;
  is_none_ = !sure && age_s_ > kSettledS &&
             estimate_s_ + kSureSigmas * sigma_s() < kToKeep * kLeastReadoutS;
}

}  // namespace egomod
