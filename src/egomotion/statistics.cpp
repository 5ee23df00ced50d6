// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/statistics.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace egomod {

double median(std::vector<double>& values, double if_empty) {
  if (values.empty()) return if_empty;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double largest_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

Matrix6d diagonal_covariance(double translation_sigma_m, double rotation_sigma_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(translation_sigma_m),
      Eigen::Vector3d::Constant(rotation_sigma_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace egomod
