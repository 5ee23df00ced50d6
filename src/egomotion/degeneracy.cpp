// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/degeneracy.hpp"

#include <Eigen/Eigenvalues>

namespace egomod {
namespace {

constexpr double kLineThickness = 4.0;  // standard deviations of the noise

}  // namespace

bool inliers_lie_on_a_line(std::span<const Correspondence> correspondences,
                           std::span<const TrackRole> roles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double variance_px2 = 0.0;
  double count = 0.0;
  for (const Correspondence& c : correspondences) {
    if (roles[c.track] != TrackRole::kInlier) continue;
    sum += c.observed_px;
    squares += c.observed_px * c.observed_px.transpose();
    variance_px2 += c.covariance_observed_px2.diagonal().maxCoeff();
    count += 1.0;
  }
  const Eigen::Matrix3d scatter = squares / count - sum * sum.transpose() / (count * count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  const double noise_px2 = kLineThickness * kLineThickness * variance_px2 / count;
  return !(solver.eigenvalues()[1] > noise_px2);  // ascending: the second largest
}

}  // namespace egomod
