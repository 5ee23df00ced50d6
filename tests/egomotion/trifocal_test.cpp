// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/trifocal.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;

// Thesis eq. 9, word for word: rows of A without row i, row q of B, row r of C.
double entry_by_determinant(const CameraMatrix& A, const CameraMatrix& B, const CameraMatrix& C,
                            int i, int q, int r) {
  Eigen::Matrix4d M;
  M.row(0) = A.row(i == 0 ? 1 : 0);
  M.row(1) = A.row(i == 2 ? 1 : 2);
  M.row(2) = B.row(q);
  M.row(3) = C.row(r);
  return (i % 2 == 0 ? 1.0 : -1.0) * M.determinant();
}

CameraMatrix camera_matrix(const Eigen::Matrix3d& K, const Eigen::Isometry3d& T) {
  CameraMatrix P;
  P << K * T.linear(), K * T.translation();
  return P;
}

TEST(Trifocal, TensorEqualsTheDeterminantsUpToACommonFactor) {
  Eigen::Matrix3d K;
  K << 525, 0, 320.6, 0, 520, 238.7, 0, 0, 1;
  std::mt19937 random(1);
  for (int k = 0; k < 20; ++k) {
    const auto A = camera_matrix(K, Eigen::Isometry3d::Identity());
    const auto B = camera_matrix(K, se3_exp(synthetic::random_motion(random, 1.0, 0.3)));
    const auto C = camera_matrix(K, se3_exp(synthetic::random_motion(random, 1.0, 0.3)));
    const TrifocalTensor tensor = trifocal_tensor(K, B, C);
    const double factor = entry_by_determinant(A, B, C, 0, 0, 0) / tensor[0](0, 0);
    for (int i = 0; i < 3; ++i)
      for (int q = 0; q < 3; ++q)
        for (int r = 0; r < 3; ++r) {
          const double expected = entry_by_determinant(A, B, C, i, q, r) / factor;
          EXPECT_NEAR(tensor[static_cast<std::size_t>(i)](q, r), expected,
                      1e-9 * (1 + std::abs(expected)));
        }
  }
}

TEST(Trifocal, TransferEqualsProjectionIntoBothCurrentImages) {
  std::mt19937 random(2);
  int seen = 0;
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d P = synthetic::random_point(random);
    const Eigen::Isometry3d T = se3_exp(synthetic::random_motion(random, 1.0, 0.35));
    const StereoTransfer transfer_stereo(kCamera, T);
    Eigen::Vector4d found;
    const bool in_front = transfer_stereo(project(kCamera, P), found);
    const Eigen::Vector3d moved = T * P;
    ASSERT_EQ(in_front, moved.z() > 0.05) << moved.z();
    if (!in_front) continue;
    ++seen;
    const Eigen::Vector3d z = project(kCamera, moved);
    const Eigen::Vector4d expected{z.x(), z.y(), z.x() - z.z(), z.y()};
    EXPECT_LT((found - expected).norm(), 1e-8 * (1 + expected.norm()));
  }
  EXPECT_GT(seen, 800);
}

}  // namespace
}  // namespace egomod
