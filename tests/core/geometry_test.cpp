// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/geometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace egomod {
namespace {

const StereoCamera kCamera{525.0, 520.0, 320.6, 238.7, 0.375, 640, 480};

TEST(Geometry, ExpAndLogAreInverse) {
  for (const double scale : {1e-9, 1e-5, 0.03, 1.0, 2.5}) {
    Vector6d xi;
    xi << 0.3, -0.2, 0.9, 0.4, -0.7, 0.5;
    xi *= scale;
    EXPECT_LT((se3_log(se3_exp(xi)) - xi).norm(), 1e-12) << scale;
  }
}

TEST(Geometry, AdjointMovesAPerturbationToTheOtherSide) {
  Vector6d xi;
  xi << 0.1, 0.2, -0.3, 0.02, -0.01, 0.05;
  Vector6d pose;
  pose << 1, -2, 3, 0.5, 0.8, -0.3;
  const Eigen::Isometry3d T = se3_exp(pose);
  const Eigen::Isometry3d left = se3_exp(adjoint(T) * xi) * T;
  const Eigen::Isometry3d right = T * se3_exp(xi);
  EXPECT_LT((left.matrix() - right.matrix()).norm(), 1e-12);
}

TEST(Geometry, LeftJacobianAgreesWithFiniteDifferences) {
  for (const double scale : {1e-6, 0.1, 2.0}) {
    const Eigen::Vector3d phi = scale * Eigen::Vector3d(0.5, -0.7, 0.4);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(k);
      const Eigen::Matrix3d back = so3_exp(-phi);
      const Eigen::Vector3d numeric =
          (so3_log(so3_exp(phi + e) * back) - so3_log(so3_exp(phi - e) * back)) / (2 * h);
      EXPECT_LT((so3_left_jacobian(phi).col(k) - numeric).norm(), 1e-8) << scale;
    }
  }
}

TEST(Geometry, OrthonormalisingRemovesWhatRoundingLeaves) {
  Eigen::Isometry3d T = se3_exp(Vector6d::Constant(0.4));
  T.linear() += 1e-6 * Eigen::Matrix3d::Ones();
  const Eigen::Isometry3d clean = orthonormalised(T);
  EXPECT_LT((clean.linear() * clean.linear().transpose() - Eigen::Matrix3d::Identity()).norm(),
            1e-14);
  EXPECT_LT((clean.linear() - T.linear()).norm(), 1e-5);
  EXPECT_EQ(clean.translation(), T.translation());
}

TEST(Geometry, CovarianceIsTheUpperTriangleRowByRow) {
  StereoObservation observation;
  observation.covariance_px2 = {1, 2, 3, 4, 5, 6};
  Eigen::Matrix3d expected;
  expected << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  EXPECT_EQ(covariance(observation), expected);
}

TEST(Geometry, TriangulationUndoesProjection) {
  const Eigen::Vector3d P{0.7, -0.4, 5.2};
  EXPECT_LT((triangulate(kCamera, project(kCamera, P)) - P).norm(), 1e-12);
}

TEST(Geometry, JacobiansAgreeWithFiniteDifferences) {
  const Eigen::Vector3d P{0.7, -0.4, 5.2};
  const Eigen::Vector3d m = project(kCamera, P);
  const double h = 1e-6;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(k);
    const Eigen::Vector3d dm = (project(kCamera, P + e) - project(kCamera, P - e)) / (2 * h);
    const Eigen::Vector3d dP =
        (triangulate(kCamera, m + e) - triangulate(kCamera, m - e)) / (2 * h);
    EXPECT_LT((project_jacobian(kCamera, P).col(k) - dm).norm(), 1e-6);
    EXPECT_LT((triangulate_jacobian(kCamera, m).col(k) - dP).norm(), 1e-6);
  }
}

TEST(Geometry, ALateRowShowsWhatTheRigHasComeToMeanwhile) {
  const Eigen::Vector3d P{0.7, -0.4, 5.2};
  Vector6d velocity;
  velocity << 0.3, -0.1, 0.8, 0.2, -0.5, 0.1;
  constexpr double kReadoutS = 1e-3;
  const Eigen::Vector3d z = project(kCamera, P);
  const double late_s = kReadoutS * (z.y() / kCamera.height_px - 0.5);
  const Eigen::Vector3d seen = project(kCamera, se3_exp(late_s * velocity).inverse() * P);
  const Eigen::Vector3d expected = z + kReadoutS * row_displacement_per_s(kCamera, P, velocity);
  EXPECT_LT((seen - expected).norm(), 1e-4);
  EXPECT_LT((at_middle_row(kCamera, seen, {kReadoutS, velocity}) - z).norm(), 1e-3);
  EXPECT_EQ(at_middle_row(kCamera, seen, {0.0, velocity}), seen);
}

TEST(Geometry, BodyFrameIsForwardLeftUp) {
  const Eigen::Isometry3d T_body_camera = default_T_body_camera();
  EXPECT_EQ(T_body_camera * Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(T_body_camera * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(T_body_camera * Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, -1));
  EXPECT_NEAR(T_body_camera.linear().determinant(), 1.0, 0);
}

}  // namespace
}  // namespace egomod
