// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/sigma_point_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <numeric>

#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;

Matrix6d random_covariance(std::mt19937& random) {
  std::normal_distribution<double> n;
  Matrix6d M;
  for (double& x : M.reshaped()) x = n(random);
  return M * M.transpose() + 0.1 * Matrix6d::Identity();
}

TEST(SigmaPoints, ReproduceMeanAndCovarianceOfALinearMapExactly) {
  std::mt19937 random(1);
  const Matrix6d P = random_covariance(random);
  const Matrix6d A = random_covariance(random);
  Vector6d mean;
  mean << 1, -2, 3, 0.1, 0.2, -0.4;
  const auto points = sigma_points(mean, P.llt().matrixL());
  Vector6d mapped_mean = Vector6d::Zero();
  for (const Vector6d& x : points) mapped_mean += A * x / double{kSigmaPoints};
  Matrix6d mapped_covariance = Matrix6d::Zero();
  for (const Vector6d& x : points) {
    const Vector6d d = A * x - mapped_mean;
    mapped_covariance += d * d.transpose() / double{kSigmaPoints};
  }
  EXPECT_LT((mapped_mean - A * mean).norm(), 1e-12 * (A * mean).norm());
  const Matrix6d expected = A * P * A.transpose();
  EXPECT_LT((mapped_covariance - expected).norm(), 1e-12 * expected.norm());
}

TEST(VelocityState, MotionAndVelocityAreInverse) {
  Vector6d y;
  y << 0.4, -0.1, 11.0, 0.2, -0.9, 0.1;
  EXPECT_LT((velocity_of(motion_of(y, 0.2), 0.2) - y).norm(), 1e-12);
}

TEST(VelocityState, PerturbationJacobianAgreesWithFiniteDifferences) {
  Vector6d y;
  y << 0.4, -0.1, 11.0, 0.2, -0.9, 0.1;
  const double dt_s = 0.3;
  const double h = 1e-6;
  const Matrix6d J = motion_perturbation_of_velocity(y, dt_s);
  for (int k = 0; k < 6; ++k) {
    const Vector6d e = h * Vector6d::Unit(k);
    const Eigen::Isometry3d T = motion_of(y, dt_s).inverse();
    const Vector6d numeric =
        (se3_log(T * motion_of(y + e, dt_s)) - se3_log(T * motion_of(y - e, dt_s))) / (2 * h);
    EXPECT_LT((J.col(k) - numeric).norm(), 1e-7);
  }
}

class SigmaPointFilterTest : public testing::Test {
 protected:
  void observe(std::size_t count, const Eigen::Isometry3d& T_previous_current,
               const synthetic::Noise& noise) {
    std::mt19937 random(4);
    while (correspondences_.size() < count) {
      const Eigen::Vector3d P = synthetic::random_point(random);
      const Eigen::Vector3d moved = T_previous_current.inverse() * P;
      if (!synthetic::visible(moved)) continue;
      const StereoObservation before = synthetic::observe(P, noise, random);
      const StereoObservation after = synthetic::observe(moved, noise, random);
      Correspondence c;
      ASSERT_TRUE(correspondence_of(kCamera, uvd(before), covariance(before), c));
      c.observed_px = uvd(after);
      c.covariance_observed_px2 = covariance(after);
      correspondences_.push_back(c);
    }
  }

  [[nodiscard]] SigmaPointResult update(const VelocityState& prior, double dt_s) const {
    SigmaPointFilter filter{SigmaPointFilterConfig{}};
    filter.prepare(kCamera, correspondences_, motion_of(prior.y, dt_s));
    std::vector<std::size_t> all(correspondences_.size());
    std::iota(all.begin(), all.end(), 0U);
    return filter.update(prior, prior.y, dt_s, all);
  }

  std::vector<Correspondence> correspondences_;
};

VelocityState broad_prior() {
  VelocityState prior;
  prior.covariance.diagonal() << 25, 25, 25, 1, 1, 1;
  return prior;
}

TEST_F(SigmaPointFilterTest, FindsTheVelocityFromRest) {
  Vector6d y;
  y << 0.5, -0.2, 3.0, 0.1, 0.6, -0.1;
  observe(60, motion_of(y, 0.2), {1e-3, 1e-3, 1e-3});
  const SigmaPointResult result = update(broad_prior(), 0.2);
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(result.observable);
  EXPECT_LT((result.posterior.y - y).norm(), 2e-3);
}

TEST_F(SigmaPointFilterTest, WithoutMeasurementsThePriorStays) {
  VelocityState prior = broad_prior();
  prior.y << 0.1, 0.2, 0.3, 0.01, 0.02, 0.03;
  const SigmaPointResult result = update(prior, 0.1);
  EXPECT_FALSE(result.observable);
  EXPECT_LT((result.posterior.y - prior.y).norm(), 1e-12);
  EXPECT_LT((result.posterior.covariance - prior.covariance).norm(), 1e-9);
}

TEST_F(SigmaPointFilterTest, AFirmPriorHoldsAgainstFewPoints) {
  observe(4, motion_of(Vector6d::Constant(0.3), 0.1), {});
  VelocityState prior = broad_prior();
  prior.covariance *= 1e-10;
  EXPECT_LT(update(prior, 0.1).posterior.y.norm(), 1e-3);
}

}  // namespace
}  // namespace egomod
