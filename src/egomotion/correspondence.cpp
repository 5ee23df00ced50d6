// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/correspondence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kMinDisparityPx = 0.1;
constexpr double kMinDisparitySigmas = 3.0;

}  // namespace

bool usable(const StereoObservation& observation) {
  const Eigen::Vector3d z = uvd(observation);
  const Eigen::Matrix3d R = covariance(observation);
  return z.allFinite() && R.allFinite() && R.diagonal().minCoeff() >= 0.0 &&
         z.z() > std::max(kMinDisparityPx, kMinDisparitySigmas * std::sqrt(R(2, 2)));
}

bool correspondence_of(const StereoCamera& camera, const Eigen::Vector3d& previous_px,
                       const Eigen::Matrix3d& covariance_previous_px2, Correspondence& result) {
  if (!previous_px.allFinite() || previous_px.z() < kMinDisparityPx) return false;
  const Eigen::Matrix3d J = triangulate_jacobian(camera, previous_px);
  result.P_previous_m = triangulate(camera, previous_px);
  result.covariance_previous_m2 = J * covariance_previous_px2 * J.transpose();
  return result.covariance_previous_m2.allFinite();
}

double squared_reprojection_error(const StereoCamera& camera,
                                  const Eigen::Isometry3d& T_current_previous,
                                  const Correspondence& c) {
  const Eigen::Vector3d P = T_current_previous * c.P_previous_m;
  if (!(P.z() > kMinDepthM)) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d e = c.observed_px - project(camera, P);
  const double e_right = e.x() - e.z();
  return e.x() * e.x() + e_right * e_right + 2 * e.y() * e.y();
}

}  // namespace egomod
