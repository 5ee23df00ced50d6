// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/robust_gauss_newton.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/statistics.hpp"

namespace egomod {
namespace {

constexpr double kBehindDistance2 = 1e3;  // of a point behind the camera: an outlier, finite
constexpr double kMinVariancePx2 = 1e-6;
constexpr double kSampleDamping = 1e-6;  // relative; a sample may be nearly degenerate
constexpr int kSampleSteps = 4;
constexpr double kMaxSampleStep = 0.5;  // m or rad

// Lower triangle of L^-1 with S = L L^T, row by row.
std::array<double, 6> inverse_cholesky(const Eigen::Matrix3d& S) {
  const double l00 = std::sqrt(std::max(S(0, 0), kMinVariancePx2));
  const double l10 = S(1, 0) / l00;
  const double l20 = S(2, 0) / l00;
  const double l11 = std::sqrt(std::max(S(1, 1) - l10 * l10, kMinVariancePx2));
  const double l21 = (S(2, 1) - l20 * l10) / l11;
  const double l22 = std::sqrt(std::max(S(2, 2) - l20 * l20 - l21 * l21, kMinVariancePx2));
  const double a = 1 / l00;
  const double c = 1 / l11;
  const double f = 1 / l22;
  const double b = -l10 * a * c;
  return {a, b, c, -(l20 * a + l21 * b) * f, -l21 * c * f, f};
}

template <int kColumns>
Eigen::Matrix<double, 3, kColumns> whitened(const std::array<double, 6>& w,
                                            const Eigen::Matrix<double, 3, kColumns>& M) {
  Eigen::Matrix<double, 3, kColumns> result;
  result.row(0) = w[0] * M.row(0);
  result.row(1) = w[1] * M.row(0) + w[2] * M.row(1);
  result.row(2) = w[3] * M.row(0) + w[4] * M.row(1) + w[5] * M.row(2);
  return result;
}

double geman_mcclure_cost(double distance2, double kernel) {
  return distance2 / (1 + distance2 / kernel);
}

}  // namespace

struct RobustGaussNewton::Normal {
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();

  [[nodiscard]] bool solve(Vector6d& xi) const {
    const Eigen::LDLT<Matrix6d> ldlt(A);
    const Vector6d d = ldlt.vectorD();
    if (ldlt.info() != Eigen::Success || !(d.minCoeff() > 1e-9 * d.maxCoeff())) return false;
    xi = ldlt.solve(b);
    return xi.allFinite();
  }
};

Eigen::Matrix<double, 3, 6> motion_jacobian(const StereoCamera& camera,
                                            const Eigen::Vector3d& P_m) {
  const double iz = 1 / P_m.z();
  const double x = P_m.x() * iz;
  const double y = P_m.y() * iz;
  Eigen::Matrix<double, 3, 6> J;
  J << -iz, 0, x * iz, x * y, -(1 + x * x), y,  //
      0, -iz, y * iz, 1 + y * y, -x * y, -x,    //
      0, 0, iz, y, -x, 0;
  J.row(0) *= camera.fx_px;
  J.row(1) *= camera.fy_px;
  J.row(2) *= camera.fx_px * camera.baseline_m * iz;
  return J;
}

void RobustGaussNewton::prepare(const StereoCamera& camera,
                                std::span<const Correspondence> correspondences,
                                const Eigen::Isometry3d& T_previous_current) {
  camera_ = camera;
  points_.clear();
  total_weight_ = 0.0;
  const Eigen::Isometry3d T = T_previous_current.inverse();
  for (const Correspondence& c : correspondences) {
    Eigen::Vector3d P = T * c.P_previous_m;
    P.z() = std::max(P.z(), kMinDepthM);
    const Eigen::Matrix3d H = project_jacobian(camera, P) * T.linear();
    const Eigen::Matrix3d S =
        c.covariance_observed_px2 + H * c.covariance_previous_m2 * H.transpose();
    points_.push_back({c.P_previous_m, c.observed_px, inverse_cholesky(S), c.static_weight});
    total_weight_ += c.static_weight;
  }
}

double RobustGaussNewton::accumulate(const Eigen::Isometry3d& T_current_previous,
                                     const Point& point, double kernel, Normal& normal) const {
  const Eigen::Vector3d P = T_current_previous * point.P_m;
  if (!(P.z() > kMinDepthM)) return kBehindDistance2;
  const Eigen::Vector3d r = whitened<1>(point.whitening, point.z_px - project(camera_, P));
  const Eigen::Matrix<double, 3, 6> J = whitened(point.whitening, motion_jacobian(camera_, P));
  const double q = r.squaredNorm();
  if (!std::isfinite(q)) return kBehindDistance2;
  const double share = kernel > 0 ? 1 / (1 + q / kernel) : 1.0;
  const double weight = point.weight * share * share;
  const Eigen::Matrix<double, 6, 3> JtW = weight * J.transpose();
  normal.A.noalias() += JtW.lazyProduct(J);
  normal.b.noalias() += JtW.lazyProduct(r);
  return q;
}

double RobustGaussNewton::distance2(const Eigen::Isometry3d& T_current_previous,
                                    std::size_t index) const {
  const Point& point = points_[index];
  const Eigen::Vector3d P = T_current_previous * point.P_m;
  if (!(P.z() > kMinDepthM)) return kBehindDistance2;
  const double d2 = whitened<1>(point.whitening, point.z_px - project(camera_, P)).squaredNorm();
  return std::isfinite(d2) ? d2 : kBehindDistance2;
}

double RobustGaussNewton::support(const Eigen::Isometry3d& T_previous_current,
                                  double abandon_below) const {
  const Eigen::Isometry3d T = T_previous_current.inverse();
  const double kernel = 4 * config_.geman_mcclure_chi2;
  double reachable = total_weight_;
  for (std::size_t i = 0; i < points_.size() && reachable > abandon_below; ++i)
    reachable -= points_[i].weight * geman_mcclure_cost(distance2(T, i), kernel) / kernel;
  return reachable;
}

bool RobustGaussNewton::fit_sample(std::span<const std::size_t> sample,
                                   Eigen::Isometry3d& T_previous_current) const {
  for (int step = 0; step < kSampleSteps; ++step) {
    const Eigen::Isometry3d T = T_previous_current.inverse();
    Normal normal;
    for (const std::size_t i : sample) accumulate(T, points_[i], 0.0, normal);
    normal.A.diagonal() *= 1 + kSampleDamping;
    Vector6d xi;
    if (!normal.solve(xi)) return false;
    T_previous_current =
        T_previous_current * se3_exp(xi.cwiseMax(-kMaxSampleStep).cwiseMin(kMaxSampleStep));
  }
  return true;
}

double RobustGaussNewton::residual_scale() {
  if (distances2_.size() < 6) return 1.0;
  const auto middle = distances2_.begin() + static_cast<std::ptrdiff_t>(distances2_.size() / 2);
  std::nth_element(distances2_.begin(), middle, distances2_.end());
  return std::max(1.0, *middle / kMedianChi2Of3);
}

double RobustGaussNewton::robust_cost(const Eigen::Isometry3d& T_current_previous) const {
  double cost = 0.0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    cost += points_[i].weight *
            geman_mcclure_cost(distance2(T_current_previous, i), config_.geman_mcclure_chi2);
  return cost;
}

GaussNewtonResult RobustGaussNewton::refine(const Eigen::Isometry3d& start, double graduation,
                                            std::size_t stride) {
  GaussNewtonResult result;
  result.T_previous_current = start;
  distances2_.clear();
  for (std::size_t i = 0; i < points_.size(); i += stride)
    if (points_[i].weight > 0.5) distances2_.push_back(distance2(start.inverse(), i));
  for (int k = 0; k < config_.max_iterations; ++k, graduation *= 0.5) {
    const Eigen::Isometry3d T = result.T_previous_current.inverse();
    result.scale = residual_scale();
    const double kernel = config_.geman_mcclure_chi2 * result.scale * std::max(1.0, graduation);
    distances2_.clear();
    Normal normal;
    for (std::size_t i = 0; i < points_.size(); i += stride) {
      const double q = accumulate(T, points_[i], kernel, normal);
      if (points_[i].weight > 0.5) distances2_.push_back(q);
    }
    Vector6d xi;
    result.solvable = normal.solve(xi);
    if (!result.solvable) break;
    result.T_previous_current = orthonormalised(result.T_previous_current * se3_exp(xi));
    if (graduation <= 1 && xi.cwiseAbs().maxCoeff() < config_.step_tolerance) break;
  }
  result.cost = robust_cost(result.T_previous_current.inverse());
  return result;
}

bool RobustGaussNewton::covariance(const GaussNewtonResult& result, Matrix6d& covariance) const {
  const Eigen::Isometry3d T = result.T_previous_current.inverse();
  const double kernel = config_.geman_mcclure_chi2 * result.scale;
  Matrix6d A = Matrix6d::Zero();
  Matrix6d B = Matrix6d::Zero();
  double weights = 0.0;
  for (const Point& point : points_) {
    const Eigen::Vector3d P = T * point.P_m;
    if (!(P.z() > kMinDepthM)) continue;
    const Eigen::Vector3d r = whitened<1>(point.whitening, point.z_px - project(camera_, P));
    const Eigen::Matrix<double, 3, 6> J = whitened(point.whitening, motion_jacobian(camera_, P));
    const double share = 1 / (1 + r.squaredNorm() / kernel);
    const double weight = point.weight * share * share;
    // The whitened residuals are isotropic, so squares are averaged over their three directions.
    const double q = r.squaredNorm();
    const Matrix6d JtJ = J.transpose().lazyProduct(J);
    A += (weight - (4.0 / 3.0) * weight * share * q / kernel) * JtJ;
    B += (weight * weight * q / 3.0) * JtJ;
    weights += weight;
  }
  const Eigen::LLT<Matrix6d> llt(A);
  const double freedom = 3 * weights - 6;
  if (llt.info() != Eigen::Success || !(freedom > 0)) return false;
  const Matrix6d A_inverse = llt.solve(Matrix6d::Identity());
  covariance = (3 * weights / freedom) * (A_inverse * B * A_inverse);
  return covariance.allFinite();
}

}  // namespace egomod
