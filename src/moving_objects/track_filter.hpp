// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "egomod/core/time.hpp"

namespace egomod {

// One pair's view of a point, in the first camera's axes, linearised where `measure` was told.
struct PointMeasurement {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  // of this pair alone
  Eigen::Matrix3d walk_m2 = Eigen::Matrix3d::Zero();        // what the track strays between pairs
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();  // one sigma of the point's constant error
  double volume_m3 = 1.0;                            // of one px^3
};

// Position, or position and velocity, of a point whose disparity has an unknown constant error b:
// b is considered, not estimated (S. Schmidt's filter), as one sigma of it.
template <int N>
struct PointModel {
  Eigen::Matrix<double, N, 1> state = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> bias_covariance = Eigen::Matrix<double, N, 1>::Zero();
};

struct MotionPrior {
  double velocity_mps = 1.5;       // standard deviation along each axis, of a point never seen
  double acceleration_mps2 = 0.3;  // of anything that moves
  double manoeuvre_hz = 0.2;       // and in proportion to its speed: what is fast turns fast
};

// A point under two beliefs at once, "it stands" and "it moves with its velocity" (U. Franke,
// C. Rabe, H. Badino, S. Gehrig, 6D-Vision, DAGM 2005), and what speaks for the second: the log
// ratio of how well each foretold the measurements. The moving one starts with a broad velocity
// and so foretells less sharply: noise alone speaks for "it stands", without a speed threshold.
struct TrackFilter {
  PointModel<3> standing;
  PointModel<6> moving;
  double evidence = 0.0;       // log likelihood ratio, moving over standing
  double misfit = 0.0;         // running mean of the moving model's chi-square, 3 for one that fits
  int updates = 0;             // 0: never seen
  double standing_chi2 = 0.0;  // of the last update
  Nanoseconds seen{0};
  Nanoseconds fresh{0};  // since when the moving model has been learning its velocity
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();  // last measured

  void start(const PointMeasurement& measurement, const MotionPrior& prior, Nanoseconds now);
  void predict(const MotionPrior& prior, Nanoseconds now);
  void update(const PointMeasurement& measurement, const MotionPrior& prior);

  [[nodiscard]] Eigen::Vector3d position_m() const { return moving.state.head<3>(); }
  [[nodiscard]] Eigen::Vector3d velocity_mps() const { return moving.state.tail<3>(); }
  [[nodiscard]] bool is_young() const { return updates < 3; }
};

inline constexpr double kLeastEvidence = -6.0;
inline constexpr double kMostEvidence = 25.0;

}  // namespace egomod
