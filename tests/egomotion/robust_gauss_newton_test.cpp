// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/robust_gauss_newton.hpp"

#include <gtest/gtest.h>

#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;

TEST(MotionJacobian, AgreesWithFiniteDifferences) {
  std::mt19937 random(1);
  const double h = 1e-6;
  for (int n = 0; n < 20; ++n) {
    const Eigen::Vector3d P = synthetic::random_point(random);
    const auto J = motion_jacobian(kCamera, P);
    for (int k = 0; k < 6; ++k) {
      const Vector6d e = h * Vector6d::Unit(k);
      const Eigen::Vector3d numeric =
          (project(kCamera, se3_exp(e).inverse() * P) - project(kCamera, se3_exp(e) * P)) / (2 * h);
      EXPECT_LT((J.col(k) - numeric).norm(), 1e-5 * (1 + numeric.norm()));
    }
  }
}

TEST(RobustGaussNewton, DistanceIsThatOfTheJointCovariance) {
  std::mt19937 random(2);
  Correspondence c;
  c.P_previous_m = {0.4, -0.2, 3.0};
  c.covariance_previous_m2 << 2e-4, 1e-5, 2e-5, 1e-5, 1e-4, 0, 2e-5, 0, 5e-4;
  c.covariance_observed_px2 << 0.02, 0.005, 0, 0.005, 0.03, 0.01, 0, 0.01, 0.05;
  const Eigen::Isometry3d T = se3_exp(synthetic::random_motion(random, 0.1, 0.05));
  c.observed_px = project(kCamera, T.inverse() * c.P_previous_m) + Eigen::Vector3d(0.3, -0.2, 0.4);
  RobustGaussNewton gn{GaussNewtonConfig{}};
  gn.prepare(kCamera, {&c, 1}, T);
  const Eigen::Matrix3d H =
      project_jacobian(kCamera, T.inverse() * c.P_previous_m) * T.inverse().linear();
  const Eigen::Matrix3d S =
      c.covariance_observed_px2 + H * c.covariance_previous_m2 * H.transpose();
  const Eigen::Vector3d r{0.3, -0.2, 0.4};
  std::vector<double> distances2;
  gn.measure_distances2(T.inverse(), distances2);
  EXPECT_NEAR(distances2[0], r.dot(S.inverse() * r), 1e-9);
}

TEST(RobustGaussNewton, PointsOnALineDoNotFixAMotion) {
  std::vector<Correspondence> line;
  for (int k = 0; k < 40; ++k) {
    Correspondence c;
    c.P_previous_m = Eigen::Vector3d(-1, 0.3, 3) + 0.05 * k * Eigen::Vector3d(1, 0.1, 0.4);
    c.covariance_previous_m2 = 1e-6 * Eigen::Matrix3d::Identity();
    c.covariance_observed_px2 = 0.01 * Eigen::Matrix3d::Identity();
    c.observed_px = project(kCamera, c.P_previous_m);
    line.push_back(c);
  }
  RobustGaussNewton gn{GaussNewtonConfig{}};
  gn.prepare(kCamera, line, Eigen::Isometry3d::Identity());
  const GaussNewtonResult result = gn.refine(Eigen::Isometry3d::Identity(), 1.0);
  EXPECT_FALSE(result.solvable);
}

}  // namespace
}  // namespace egomod
