// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/robust_gauss_newton.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/ransac.hpp"
#include "egomod/egomotion/statistics.hpp"
#include "residual_kernels.hpp"

namespace egomod {
namespace {

using Column = ResidualColumns::Column;

constexpr double kBehindDistance2 = 1e3;  // of a point behind the camera: an outlier, finite
constexpr double kMinVariancePx2 = 1e-6;
constexpr double kSampleDamping = 1e-6;  // relative; a sample may be nearly degenerate
constexpr int kSampleSteps = 4;
constexpr double kMaxSampleStep = 0.5;  // m or rad
constexpr double kLeastLeft = 2.0;      // of six freedoms: below, too few cells for a say in common
constexpr double kTellingWeight = 0.5;  // of points that tell the scale of the residuals

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

double geman_mcclure_cost(double distance2, double kernel) {
  return distance2 / (1 + distance2 / kernel);
}

ResidualGeometry geometry(const StereoCamera& camera, const Eigen::Isometry3d& T_current_previous) {
  ResidualGeometry g{.R = {},
                     .t_m = {},
                     .fx_px = camera.fx_px,
                     .fy_px = camera.fy_px,
                     .cx_px = camera.cx_px,
                     .cy_px = camera.cy_px,
                     .fx_baseline_px_m = camera.fx_px * camera.baseline_m,
                     .min_depth_m = kMinDepthM,
                     .behind_distance2 = kBehindDistance2};
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) g.R[3 * row + k] = T_current_previous.linear()(row, k);
    g.t_m[row] = T_current_previous.translation()[row];
  }
  return g;
}

ResidualColumns view_of(const std::array<std::vector<double>, kResidualColumns>& columns) {
  ResidualColumns view{.column = {}, .count = columns[0].size()};
  for (std::size_t k = 0; k < kResidualColumns; ++k) view.column[k] = columns[k].data();
  return view;
}

Matrix6d matrix(const NormalSums& sums) {
  Matrix6d A;
  for (int row = 0, n = 0; row < 6; ++row)
    for (int k = 0; k <= row; ++k, ++n) A(row, k) = A(k, row) = sums.A[n];
  return A;
}

bool solve(const Matrix6d& A, const NormalSums& sums, Vector6d& xi) {
  const Eigen::LDLT<Matrix6d> ldlt(A);
  const Vector6d d = ldlt.vectorD();
  if (ldlt.info() != Eigen::Success || !(d.minCoeff() > 1e-9 * d.maxCoeff())) return false;
  xi = ldlt.solve(Eigen::Map<const Vector6d>(sums.b));
  return xi.allFinite();
}

}  // namespace

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

void RobustGaussNewton::reserve(std::size_t points) {
  const std::size_t places = points + kResidualLanes;
  for (std::vector<double>& column : columns_) column.reserve(places);
  distances2_.reserve(places);
  scratch_.reserve(places);
}

void RobustGaussNewton::prepare(const StereoCamera& camera,
                                std::span<const Correspondence> correspondences,
                                const Eigen::Isometry3d& T_previous_current, std::size_t stride) {
  camera_ = camera;
  total_weight_ = 0.0;
  for (std::vector<double>& column : columns_) column.clear();
  const Eigen::Isometry3d T = T_previous_current.inverse();
  for (std::size_t i = 0; i < correspondences.size(); i += stride) add(correspondences[i], T);
  size_ = columns_[0].size();
  fill_up();
}

void RobustGaussNewton::add(const Correspondence& c, const Eigen::Isometry3d& T_current_previous) {
  Eigen::Vector3d P = T_current_previous * c.P_previous_m;
  P.z() = std::max(P.z(), kMinDepthM);
  const Eigen::Matrix3d H = project_jacobian(camera_, P) * T_current_previous.linear();
  const Eigen::Matrix3d S =
      c.covariance_observed_px2 + H * c.covariance_previous_m2 * H.transpose();
  const std::array<double, 6> whitening = inverse_cholesky(S);
  for (int k = 0; k < 3; ++k) {
    columns_[Column::kX + static_cast<std::size_t>(k)].push_back(c.P_previous_m[k]);
    columns_[Column::kU + static_cast<std::size_t>(k)].push_back(c.observed_px[k]);
  }
  for (std::size_t k = 0; k < whitening.size(); ++k)
    columns_[Column::kWhitening + k].push_back(whitening[k]);
  columns_[Column::kWeight].push_back(c.static_weight);
  total_weight_ += c.static_weight;
}

void RobustGaussNewton::fill_up() {
  const std::size_t places = (size_ + kResidualLanes - 1) / kResidualLanes * kResidualLanes;
  for (std::size_t k = 0; k < kColumns; ++k)
    columns_[k].resize(places, k == Column::kZ ? 1.0 : 0.0);
  distances2_.resize(places);
}

void RobustGaussNewton::measure_distances2(const Eigen::Isometry3d& T_current_previous,
                                           std::vector<double>& distances2) const {
  distances2.resize(columns_[0].size());
  residual_kernels().distances2(view_of(columns_), geometry(camera_, T_current_previous),
                                distances2.data());
}

double RobustGaussNewton::robust_sum(const Eigen::Isometry3d& T_previous_current, double kernel) {
  measure_distances2(T_previous_current.inverse(), distances2_);
  double sum = 0.0;
  for (std::size_t i = 0; i < size_; ++i)
    sum += columns_[Column::kWeight][i] * geman_mcclure_cost(distances2_[i], kernel);
  return sum;
}

double RobustGaussNewton::support(const Eigen::Isometry3d& T_previous_current) {
  const double kernel = 4 * config_.geman_mcclure_chi2;
  return total_weight_ - robust_sum(T_previous_current, kernel) / kernel;
}

double RobustGaussNewton::cost(const Eigen::Isometry3d& T_previous_current) {
  return robust_sum(T_previous_current, config_.geman_mcclure_chi2);
}

bool RobustGaussNewton::fit_sample(std::span<const std::size_t> sample,
                                   Eigen::Isometry3d& T_previous_current) const {
  static_assert(kSampleSize <= kResidualLanes);
  double columns[kColumns][kResidualLanes] = {};
  ResidualColumns view{.column = {}, .count = kResidualLanes};
  for (std::size_t k = 0; k < kColumns; ++k) {
    view.column[k] = columns[k];
    for (std::size_t i = 0; i < sample.size(); ++i) columns[k][i] = columns_[k][sample[i]];
  }
  double weights[kResidualLanes] = {};
  std::fill_n(weights, sample.size(), 1.0);
  for (int step = 0; step < kSampleSteps; ++step) {
    NormalSums sums;
    residual_kernels().accumulate_weighted(view, geometry(camera_, T_previous_current.inverse()),
                                           weights, sums);
    Matrix6d A = matrix(sums);
    A.diagonal() *= 1 + kSampleDamping;
    Vector6d xi;
    if (!solve(A, sums, xi)) return false;
    T_previous_current =
        T_previous_current * se3_exp(xi.cwiseMax(-kMaxSampleStep).cwiseMin(kMaxSampleStep));
  }
  return true;
}

double RobustGaussNewton::residual_scale() {
  scratch_.clear();
  for (std::size_t i = 0; i < size_; ++i)
    if (columns_[Column::kWeight][i] > kTellingWeight) scratch_.push_back(distances2_[i]);
  if (scratch_.size() < 6) return 1.0;
  return std::max(1.0, median(scratch_, kMedianChi2Of3) / kMedianChi2Of3);
}

GaussNewtonResult RobustGaussNewton::refine(const Eigen::Isometry3d& start, double graduation) {
  GaussNewtonResult result;
  result.T_previous_current = start;
  const ResidualColumns points = view_of(columns_);
  measure_distances2(start.inverse(), distances2_);
  for (int k = 0; k < config_.max_iterations; ++k, graduation *= 0.5) {
    result.scale = residual_scale();
    NormalSums sums;
    residual_kernels().accumulate(
        points, geometry(camera_, result.T_previous_current.inverse()),
        config_.geman_mcclure_chi2 * result.scale * std::max(1.0, graduation), distances2_.data(),
        sums);
    Vector6d xi;
    result.solvable = solve(matrix(sums), sums, xi);
    if (!result.solvable) break;
    result.T_previous_current = orthonormalised(result.T_previous_current * se3_exp(xi));
    if (graduation <= 1 && xi.cwiseAbs().maxCoeff() < config_.step_tolerance) break;
  }
  return result;
}

bool RobustGaussNewton::covariance(const GaussNewtonResult& result, Matrix6d& covariance) {
  const Eigen::Isometry3d T = result.T_previous_current.inverse();
  const double kernel = config_.geman_mcclure_chi2 * result.scale;
  measure_distances2(T, distances2_);
  std::vector<double>& curvature = scratch_;
  curvature.assign(distances2_.size(), 0.0);
  std::vector<double>& noise = distances2_;
  double weights = 0.0;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const double q = distances2_[i];
    const double share = 1 / (1 + q / kernel);
    const double weight = q < kBehindDistance2 ? columns_[Column::kWeight][i] * share * share : 0.0;
    // The whitened residuals are isotropic, so squares are averaged over their three directions.
    curvature[i] = weight - (4.0 / 3.0) * weight * share * q / kernel;
    noise[i] = weight * weight * q / 3.0;
    weights += weight;
  }
  const ResidualColumns points = view_of(columns_);
  const ResidualGeometry at = geometry(camera_, T);
  NormalSums sums;
  residual_kernels().accumulate_weighted(points, at, curvature.data(), sums);
  const Eigen::LLT<Matrix6d> llt(matrix(sums));
  const double freedom = 3 * weights - 6;
  if (llt.info() != Eigen::Success || !(freedom > 0)) return false;
  const Matrix6d A_inverse = llt.solve(Matrix6d::Identity());
  residual_kernels().accumulate_weighted(points, at, noise.data(), sums);
  noise_ = (3 * weights / freedom) * matrix(sums);
  covariance = A_inverse * noise_ * A_inverse;
  return covariance.allFinite();
}

std::size_t RobustGaussNewton::cell_of(std::size_t i, double median_disparity_px) const {
  const auto place = [](double x_px, int size_px, std::size_t count) {
    const double share = std::clamp(x_px / std::max(1, size_px), 0.0, 1.0);
    return std::min(static_cast<std::size_t>(share * static_cast<double>(count)), count - 1);
  };
  const std::size_t column = place(columns_[Column::kU][i], camera_.width_px, kCellColumns);
  const std::size_t row = place(columns_[Column::kV][i], camera_.height_px, kCellRows);
  const std::size_t near = columns_[Column::kD][i] > median_disparity_px ? 1 : 0;
  return 2 * (row * kCellColumns + column) + near;
}

void RobustGaussNewton::sort_into_cells() {
  scratch_.assign(columns_[Column::kD].begin(), columns_[Column::kD].end());
  scratch_.resize(size_);
  const double median_disparity_px = median(scratch_, 0.0);
  std::array<std::size_t, kCells> counts{};
  cells_.reserve(columns_[0].capacity());
  cells_.resize(size_);
  for (std::size_t i = 0; i < size_; ++i) {
    cells_[i] = cell_of(i, median_disparity_px);
    ++counts[cells_[i]];
  }
  for (std::size_t c = 0; c < kCells; ++c)
    cell_begins_[c + 1] =
        cell_begins_[c] + (counts[c] + kResidualLanes - 1) / kResidualLanes * kResidualLanes;
  for (std::size_t k = 0; k < kColumns; ++k) {
    by_cell_[k].reserve(columns_[0].capacity() + kCells * kResidualLanes);
    by_cell_[k].assign(cell_begins_[kCells], k == Column::kZ ? 1.0 : 0.0);
    std::array<std::size_t, kCells> next{};
    for (std::size_t i = 0; i < size_; ++i)
      by_cell_[k][cell_begins_[cells_[i]] + next[cells_[i]]++] = columns_[k][i];
  }
}

std::optional<double> RobustGaussNewton::common_error(const GaussNewtonResult& result) {
  sort_into_cells();
  const ResidualGeometry at = geometry(camera_, result.T_previous_current.inverse());
  std::array<Matrix6d, kCells> A;
  Matrix6d A_all = Matrix6d::Zero();
  Matrix6d pulls = Matrix6d::Zero();
  distances2_.reserve(columns_[0].capacity() + kCells * kResidualLanes);
  distances2_.resize(by_cell_[0].size());
  for (std::size_t c = 0; c < kCells; ++c) {
    ResidualColumns points{.column = {}, .count = cell_begins_[c + 1] - cell_begins_[c]};
    for (std::size_t k = 0; k < kColumns; ++k)
      points.column[k] = by_cell_[k].data() + cell_begins_[c];
    NormalSums sums;
    residual_kernels().accumulate(points, at, config_.geman_mcclure_chi2 * result.scale,
                                  distances2_.data() + cell_begins_[c], sums);
    const Eigen::Map<const Vector6d> pull(sums.b);
    pulls += pull * pull.transpose();
    A[c] = matrix(sums);
    A_all += A[c];
  }
  // The fit takes from each cell's pull what the cell had a say in.
  const Eigen::LLT<Matrix6d> all(A_all);
  const Eigen::LLT<Matrix6d> noise(noise_);
  double left = 6.0;
  for (const Matrix6d& a : A) {
    const Matrix6d say = all.solve(a);
    left -= (say * say).trace();
  }
  const double common = noise.solve(pulls).trace() / left;
  if (!(left > kLeastLeft) || !std::isfinite(common)) return std::nullopt;
  return common;
}

}  // namespace egomod
