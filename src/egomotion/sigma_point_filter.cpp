// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/sigma_point_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/trifocal.hpp"

namespace egomod {
namespace {

// Sigma points need not spread wider than this to see the measurement's curvature; a prior that is
// nearly flat would put them behind the points.
constexpr double kMaxSpreadM = 0.05;
constexpr double kMaxSpreadRad = 0.02;

const double kSpread = std::sqrt(6.0);

// Cholesky factor for the first linearisation: the prior's, but no wider than points can stand.
Matrix6d bounded_cholesky(const Matrix6d& covariance, double dt_s) {
  Vector6d sigma = covariance.diagonal().cwiseSqrt();
  sigma.head<3>() = sigma.head<3>().cwiseMin(kMaxSpreadM / dt_s);
  sigma.tail<3>() = sigma.tail<3>().cwiseMin(kMaxSpreadRad / dt_s);
  return sigma.asDiagonal();
}

// Left image, then right: both see the same row, so each carries half of what is known of it.
Eigen::Vector4d left_right_variance(const Eigen::Matrix3d& uvd) {
  return {uvd(0, 0), 2 * uvd(1, 1), uvd(0, 0) - 2 * uvd(0, 2) + uvd(2, 2), 2 * uvd(1, 1)};
}

// The true covariance of those four, of which R keeps the diagonal.
Eigen::Matrix4d left_right_covariance(const Eigen::Matrix3d& uvd) {
  Eigen::Matrix<double, 4, 3> J;
  J << 1, 0, 0, 0, 1, 0, 1, 0, -1, 0, 1, 0;
  return J * uvd * J.transpose();
}

}  // namespace

std::array<Vector6d, kSigmaPoints> sigma_points(const Vector6d& mean, const Matrix6d& cholesky) {
  std::array<Vector6d, kSigmaPoints> points;
  for (int j = 0; j < 6; ++j) {
    const Vector6d step = kSpread * cholesky.col(j);
    points[static_cast<std::size_t>(2 * j)] = mean + step;
    points[static_cast<std::size_t>(2 * j + 1)] = mean - step;
  }
  return points;
}

Eigen::Isometry3d motion_of(const Vector6d& y, double dt_s) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = so3_exp(y.tail<3>() * dt_s);
  T.translation() = y.head<3>() * dt_s;
  return T;
}

Vector6d velocity_of(const Eigen::Isometry3d& T_previous_current, double dt_s) {
  Vector6d y;
  y << T_previous_current.translation() / dt_s, so3_log(T_previous_current.linear()) / dt_s;
  return y;
}

Matrix6d motion_perturbation_of_velocity(const Vector6d& y, double dt_s) {
  const Eigen::Vector3d phi = y.tail<3>() * dt_s;
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = so3_exp(-phi) * dt_s;
  J.bottomRightCorner<3, 3>() = so3_left_jacobian(-phi) * dt_s;
  return J;
}

VelocityState predicted(const SigmaPointFilterConfig& config, const VelocityState& state,
                        double dt_s) {
  VelocityState next = state;
  const auto square = [](double x) { return x * x; };
  next.covariance.diagonal().head<3>().array() += square(config.acceleration_sigma_mps2 * dt_s);
  next.covariance.diagonal().tail<3>().array() +=
      square(config.turn_acceleration_sigma_radps2 * dt_s);
  return next;
}

void SigmaPointFilter::prepare(const StereoCamera& camera,
                               std::span<const Correspondence> correspondences,
                               const Eigen::Isometry3d& T_previous_current) {
  camera_ = camera;
  points_.clear();
  const Eigen::Isometry3d T = T_previous_current.inverse();
  for (const Correspondence& c : correspondences) {
    Eigen::Vector3d P = T * c.P_previous_m;
    P.z() = std::max(P.z(), kMinDepthM);
    const Eigen::Matrix3d H = project_jacobian(camera, P) * T.linear();
    const Eigen::Matrix3d S =
        c.covariance_observed_px2 + H * c.covariance_previous_m2 * H.transpose();
    const Eigen::Vector3d& z = c.observed_px;
    points_.push_back({project(camera, c.P_previous_m),
                       {z.x(), z.y(), z.x() - z.z(), z.y()},
                       left_right_variance(S),
                       left_right_covariance(S)});
  }
}

// In coordinates s with y = mean + cholesky * s, where the sigma points are +-sqrt(6) e_j and the
// regression matrix is the plain difference quotient.
struct SigmaPointFilter::Linearised {
  Matrix6d information = Matrix6d::Zero();
  Vector6d vector = Vector6d::Zero();
  Matrix6d vector_covariance = Matrix6d::Zero();
};

SigmaPointFilter::Linearised SigmaPointFilter::linearise(const Vector6d& mean,
                                                         const Matrix6d& cholesky, double dt_s,
                                                         std::span<const std::size_t> used) const {
  const auto make = [&](const Vector6d& y) {
    return StereoTransfer(camera_, motion_of(y, dt_s).inverse());
  };
  const auto s = sigma_points(mean, cholesky);
  const std::array<StereoTransfer, kSigmaPoints> h{
      make(s[0]), make(s[1]), make(s[2]), make(s[3]), make(s[4]),  make(s[5]),
      make(s[6]), make(s[7]), make(s[8]), make(s[9]), make(s[10]), make(s[11])};
  Linearised sum;
  for (const std::size_t index : used) {
    const Point& point = points_[index];
    Eigen::Matrix<double, 4, kSigmaPoints> Z;
    bool visible = true;
    Eigen::Vector4d z;
    for (std::size_t k = 0; k < kSigmaPoints && visible; ++k) {
      visible = h[k](point.previous_px, z);
      Z.col(static_cast<Eigen::Index>(k)) = z;
    }
    if (!visible) continue;
    const Eigen::Vector4d z_mean = Z.rowwise().mean();
    Eigen::Matrix<double, 4, 6> A;
    for (int j = 0; j < 6; ++j) A.col(j) = (Z.col(2 * j) - Z.col(2 * j + 1)) / (2 * kSpread);
    // What the linear map leaves unexplained is noise of the measurement.
    const Eigen::Vector4d spread = (Z.colwise() - z_mean).array().square().rowwise().mean();
    const Eigen::Vector4d unexplained =
        (spread.array() - A.array().square().rowwise().sum()).max(0.0);
    const Eigen::Vector4d weight = (point.variance_px2 + unexplained).cwiseInverse();
    const Eigen::Matrix<double, 6, 4> AtW = A.transpose() * weight.asDiagonal();
    sum.information.noalias() += AtW * A;
    sum.vector.noalias() += AtW * (point.z_px - z_mean);
    sum.vector_covariance.noalias() += AtW * point.covariance_px2 * AtW.transpose();
  }
  return sum;
}

SigmaPointResult SigmaPointFilter::update(const VelocityState& prior, const Vector6d& start,
                                          double dt_s, std::span<const std::size_t> used) const {
  SigmaPointResult result;
  result.posterior = {start, prior.covariance};
  const Matrix6d prior_information = prior.covariance.inverse();
  Matrix6d L = bounded_cholesky(prior.covariance, dt_s);
  for (int k = 0; k < config_.max_iterations && !result.converged; ++k) {
    const Linearised measured = linearise(result.posterior.y, L, dt_s, used);
    const Matrix6d Lt_prior = L.transpose() * prior_information;
    const Eigen::LDLT<Matrix6d> ldlt(measured.information + Lt_prior * L);
    const Vector6d step = ldlt.solve(measured.vector + Lt_prior * (prior.y - result.posterior.y));
    if (ldlt.info() != Eigen::Success || !step.allFinite()) return result;
    result.posterior.y += L * step;
    // A diagonal R takes left and right for independent. What the estimate's error really is:
    const Matrix6d gain = L * ldlt.solve(Matrix6d::Identity());
    result.covariance = gain * (measured.vector_covariance + Lt_prior * L) * gain.transpose();
    const Eigen::LDLT<Matrix6d> without_prior(measured.information);
    result.observable = without_prior.isPositive() && without_prior.rcond() > 1e-9;
    result.posterior.covariance = L * ldlt.solve(L.transpose());
    const Eigen::LLT<Matrix6d> posterior(result.posterior.covariance);
    if (posterior.info() != Eigen::Success) return result;
    const Vector6d in_sigmas = posterior.matrixL().solve(L * step);
    result.converged = in_sigmas.cwiseAbs().maxCoeff() < config_.step_tolerance;
    L = posterior.matrixL();
  }
  return result;
}

}  // namespace egomod
