// SPDX-License-Identifier: Apache-2.0
#include "residual_kernels.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "egomod/egomotion/robust_gauss_newton.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using Column = ResidualColumns::Column;
using synthetic::kCamera;

constexpr std::size_t kPoints = 22;  // the last vector is not full
constexpr std::size_t kPlaces = 24;
constexpr double kBehind = 1e3;
constexpr double kTolerance = 1e-10;  // relative: sums in another order

// Points seen with errors of some pixels, one of them behind the camera.
struct Scene {
  Scene() {
    std::mt19937 random(3);
    T = se3_exp(synthetic::random_motion(random, 0.2, 0.1));
    for (auto& column : columns) column.assign(kPlaces, 0.0);
    std::fill(columns[Column::kZ].begin(), columns[Column::kZ].end(), 1.0);
    std::uniform_real_distribution<double> unit(0.1, 1.0);
    for (std::size_t i = 0; i < kPoints; ++i) {
      Eigen::Vector3d P = synthetic::random_point(random);
      const Eigen::Vector3d z = project(kCamera, T * P) + 2.0 * synthetic::gaussian3(random);
      if (i == 5) P.z() = -2.0;
      for (int k = 0; k < 3; ++k) {
        columns[Column::kX + static_cast<std::size_t>(k)][i] = P[k];
        columns[Column::kU + static_cast<std::size_t>(k)][i] = z[k];
      }
      for (std::size_t k = 0; k < 7; ++k) columns[Column::kWhitening + k][i] = unit(random);
    }
  }
  [[nodiscard]] ResidualColumns view() const {
    ResidualColumns view{.column = {}, .count = kPlaces};
    for (std::size_t k = 0; k < kResidualColumns; ++k) view.column[k] = columns[k].data();
    return view;
  }
  [[nodiscard]] ResidualGeometry geometry() const {
    ResidualGeometry g{.R = {},
                       .t_m = {},
                       .fx_px = kCamera.fx_px,
                       .fy_px = kCamera.fy_px,
                       .cx_px = kCamera.cx_px,
                       .cy_px = kCamera.cy_px,
                       .fx_baseline_px_m = kCamera.fx_px * kCamera.baseline_m,
                       .min_depth_m = kMinDepthM,
                       .behind_distance2 = kBehind};
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 3; ++k) g.R[3 * row + k] = T.linear()(row, k);
      g.t_m[row] = T.translation()[row];
    }
    return g;
  }
  [[nodiscard]] Eigen::Vector3d vector(Column first, std::size_t i) const {
    return {columns[first][i], columns[first + 1][i], columns[first + 2][i]};
  }
  [[nodiscard]] Eigen::Matrix3d whitening(std::size_t i) const {
    const auto w = [&](std::size_t k) { return columns[Column::kWhitening + k][i]; };
    Eigen::Matrix3d L;
    L << w(0), 0, 0, w(1), w(2), 0, w(3), w(4), w(5);
    return L;
  }

  Eigen::Isometry3d T;  // current from previous
  std::array<std::vector<double>, kResidualColumns> columns;
};

// What the kernels must give, by the plain formulas.
struct Expected {
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  std::array<double, kPlaces> distances2{};
};

template <typename Weight>
Expected expected(const Scene& scene, const Weight& weight) {
  Expected e;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d P = scene.T * scene.vector(Column::kX, i);
    e.distances2[i] = kBehind;
    if (P.z() <= kMinDepthM) continue;
    const Eigen::Vector3d r =
        scene.whitening(i) * (scene.vector(Column::kU, i) - project(kCamera, P));
    const Eigen::Matrix<double, 3, 6> J = scene.whitening(i) * motion_jacobian(kCamera, P);
    e.distances2[i] = r.squaredNorm();
    e.A += weight(i, r.squaredNorm()) * J.transpose() * J;
    e.b += weight(i, r.squaredNorm()) * J.transpose() * r;
  }
  return e;
}

void expect_equal(const NormalSums& sums, const Expected& e) {
  for (int row = 0, n = 0; row < 6; ++row) {
    EXPECT_NEAR(sums.b[row], e.b[row], kTolerance * e.b.norm());
    for (int k = 0; k <= row; ++k, ++n)
      EXPECT_NEAR(sums.A[n], e.A(row, k), kTolerance * e.A.norm()) << row << ',' << k;
  }
}

void check(const ResidualKernels& kernels) {
  const Scene scene;
  const auto point_weight = [&](std::size_t i) { return scene.columns[Column::kWeight][i]; };
  std::array<double, kPlaces> distances2{};
  NormalSums sums;

  kernels.distances2(scene.view(), scene.geometry(), distances2.data());
  const Expected plain = expected(scene, [&](std::size_t i, double) { return point_weight(i); });
  for (std::size_t i = 0; i < kPoints; ++i)
    EXPECT_NEAR(distances2[i], plain.distances2[i], kTolerance * (1.0 + plain.distances2[i]));

  kernels.accumulate(scene.view(), scene.geometry(), std::numeric_limits<double>::infinity(),
                     distances2.data(), sums);
  expect_equal(sums, plain);

  constexpr double kKernel = 6.0;
  kernels.accumulate(scene.view(), scene.geometry(), kKernel, distances2.data(), sums);
  expect_equal(sums, expected(scene, [&](std::size_t i, double q) {
                 return point_weight(i) / std::pow(1.0 + q / kKernel, 2);
               }));

  std::array<double, kPlaces> weights{};
  for (std::size_t i = 0; i < kPoints; ++i) weights[i] = 0.3 * static_cast<double>(i);
  kernels.accumulate_weighted(scene.view(), scene.geometry(), weights.data(), sums);
  expect_equal(sums, expected(scene, [&](std::size_t i, double) { return weights[i]; }));
}

TEST(ResidualKernels, BaselineGivesTheNormalEquations) { check(baseline::residual_kernels()); }

TEST(ResidualKernels, ThoseChosenHereGiveTheNormalEquations) { check(residual_kernels()); }

}  // namespace
}  // namespace egomod
