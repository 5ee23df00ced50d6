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

// A resting rig that sees points at places known but for their noise, and what came of it.
struct NoisyFit {
  double error2 = 0.0;  // squared Mahalanobis distance from the true motion
  double common_error = 0.0;
};

struct FoundMotion {
  explicit FoundMotion(const std::vector<Correspondence>& points) {
    gn.prepare(kCamera, points, Eigen::Isometry3d::Identity());
    result = gn.refine(Eigen::Isometry3d::Identity(), 1.0);
    EXPECT_TRUE(gn.covariance(result, covariance));
  }
  RobustGaussNewton gn{GaussNewtonConfig{}};
  GaussNewtonResult result;
  Matrix6d covariance;
};

// `shear_px`: how far rows are displaced, from the upper to the lower edge, on top of the noise.
NoisyFit fit_noisy(std::uint32_t seed, double shear_px) {
  constexpr int kPoints = 600;
  std::mt19937 random(seed);
  std::vector<Correspondence> points;
  const Eigen::Vector3d sigma_px{0.15, 0.15, 0.2};
  for (int k = 0; k < kPoints; ++k) {
    Correspondence c;
    c.P_previous_m = synthetic::random_point(random);
    c.covariance_observed_px2 = sigma_px.cwiseAbs2().asDiagonal();
    c.observed_px = project(kCamera, c.P_previous_m);
    c.observed_px.x() += shear_px * (c.observed_px.y() / kCamera.height_px - 0.5);
    c.observed_px += sigma_px.cwiseProduct(synthetic::gaussian3(random));
    points.push_back(c);
  }
  FoundMotion found(points);
  const Vector6d e = se3_log(found.result.T_previous_current);
  return {e.dot(found.covariance.ldlt().solve(e)),
          found.gn.common_error(found.result).value_or(0.0)};
}

TEST(RobustGaussNewton, CovarianceIsThatOfTheErrors) {
  constexpr int kRuns = 400;
  double error2 = 0.0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) error2 += fit_noisy(seed, 0.0).error2;
  // 99 % of the sums of so many chi-squares, by their normal approximation.
  const double freedom = 6.0 * kRuns;
  EXPECT_NEAR(error2, freedom, 2.58 * std::sqrt(2 * freedom));
}

TEST(RobustGaussNewton, PointsThatErrOnTheirOwnHaveNoErrorInCommon) {
  constexpr int kRuns = 200;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) sum += fit_noisy(seed, 0.0).common_error;
  EXPECT_NEAR(sum / kRuns, 1.0, 0.06);
}

TEST(RobustGaussNewton, RowsThatAreDisplacedOneAfterTheOtherErrInCommon) {
  for (std::uint32_t seed = 0; seed < 10; ++seed)
    EXPECT_GT(fit_noisy(seed, 0.8).common_error, 3.0) << seed;
}

TEST(RobustGaussNewton, PointsInOneCellDoNotTellWhatIsInCommon) {
  std::mt19937 random(3);
  std::vector<Correspondence> points;
  for (int k = 0; k < 100; ++k) {
    Correspondence c;
    c.P_previous_m = Eigen::Vector3d(0.3, 0.2, 3.0) + 0.1 * synthetic::gaussian3(random);
    c.covariance_observed_px2 = 0.01 * Eigen::Matrix3d::Identity();
    c.observed_px = project(kCamera, c.P_previous_m) + 0.1 * synthetic::gaussian3(random);
    points.push_back(c);
  }
  FoundMotion found(points);
  EXPECT_FALSE(found.gn.common_error(found.result).has_value());
}

}  // namespace
}  // namespace egomod
