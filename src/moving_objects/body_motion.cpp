// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/body_motion.hpp"

#include <Eigen/LU>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "moving_objects/motion_groups.hpp"

namespace egomod {
namespace {

// The filters are ready for manoeuvres at any time. While a body makes none, their velocities err
// by this share of the variance that they say; what a manoeuvre adds is `Manoeuvre`'s.
constexpr double kSteadyShare = 0.034;
// What the points of a surface err by together is an error of the disparity, and along the ray: of
// the variances across it this share is left.
constexpr double kAcrossShare = 0.35;
constexpr double kTurnPrior_radps = 0.7;
// Of the angular velocity, 3 dof. Far above what noise makes: a body that brakes, while some of its
// points lag behind more than others, looks as if it turned.
constexpr double kTurnChi2 = 50.0;
constexpr std::size_t kTurnPoints = 6;

// Normal equations of v and w.
struct Equations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d weighted = Vector6d::Zero();
};

Equations equations_of(std::span<const PointSample> points, Members members,
                       const Eigen::Vector3d& at_m) {
  Equations e;
  for (const auto i : members) {
    const Eigen::Matrix3d W = velocity_information(points[i]);
    const Eigen::Matrix3d S = skew(points[i].position_m - at_m);  // v_i = v - S w
    const Eigen::Matrix3d WS = W * S;
    const Eigen::Vector3d Wv = W * points[i].velocity_mps;
    e.information.topLeftCorner<3, 3>() += W;
    e.information.topRightCorner<3, 3>() -= WS;
    e.information.bottomRightCorner<3, 3>().noalias() -= S * WS;
    e.weighted.head<3>() += Wv;
    e.weighted.tail<3>().noalias() += S * Wv;
  }
  e.information.bottomLeftCorner<3, 3>() = e.information.topRightCorner<3, 3>().transpose();
  return e;
}

// Harmonic, as the mean of the covariances is: one point that misfits does not speak for the
// others. 0 where a point is not filtered.
double mean_agility_m2ps3(std::span<const PointSample> points, Members members) {
  double inverse = 0.0;
  for (const auto i : members) {
    if (!(points[i].agility_m2ps3 > 0.0)) return 0.0;
    inverse += 1.0 / points[i].agility_m2ps3;
  }
  return static_cast<double>(members.size()) / inverse;
}

Eigen::Matrix3d with_share_across(const Eigen::Matrix3d& C, const Eigen::Vector3d& at_m) {
  const double across = std::sqrt(kAcrossShare);
  const Eigen::Vector3d ray = at_m.normalized();
  const Eigen::Matrix3d D =
      across * Eigen::Matrix3d::Identity() + (1.0 - across) * ray * ray.transpose();
  return D * C * D;
}

}  // namespace

BodyMotion fit_body_motion(std::span<const PointSample> points, Members members,
                           const Eigen::Vector3d& at_m, double correlation) {
  Equations e = equations_of(points, members, at_m);
  // 1/K of independent errors becomes rho + (1 - rho)/K.
  const double weight = 1.0 / (kSteadyShare * static_cast<double>(members.size()) *
                               mean_variance_factor(members.size(), correlation));
  BodyMotion body;
  if (const double agility_m2ps3 = mean_agility_m2ps3(points, members); agility_m2ps3 > 0.0)
    body.lag_s = static_cast<double>(members.size()) / agility_m2ps3 *
                 e.information.topLeftCorner<3, 3>().inverse();
  e.information *= weight;
  e.weighted *= weight;
  const Eigen::Matrix3d mean_covariance = e.information.topLeftCorner<3, 3>().inverse();
  body.velocity_mps = mean_covariance * e.weighted.head<3>();
  body.velocity_covariance_m2ps2 = with_share_across(mean_covariance, at_m);
  if (members.size() < kTurnPoints) return body;

  e.information.diagonal().tail<3>().array() += 1.0 / (kTurnPrior_radps * kTurnPrior_radps);
  const Matrix6d covariance = e.information.inverse();
  const Vector6d motion = covariance * e.weighted;
  const Eigen::Vector3d turn_radps = motion.tail<3>();
  const Eigen::Matrix3d turn_information = covariance.bottomRightCorner<3, 3>().inverse();
  if (turn_radps.dot(turn_information * turn_radps) < kTurnChi2) return body;
  body.velocity_mps = motion.head<3>();
  body.velocity_covariance_m2ps2 = with_share_across(covariance.topLeftCorner<3, 3>(), at_m);
  body.angular_velocity_radps = turn_radps;
  return body;
}

}  // namespace egomod
