// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/filter_kernels.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "reference_filter.hpp"

namespace egomod {
namespace {

constexpr StereoCamera kFilterCamera{
    .fx_px = 525.0, .fy_px = 520.0, .cx_px = 319.5, .cy_px = 239.5, .baseline_m = 0.375};
constexpr Nanoseconds kFilterInterval{33'333'333};
constexpr int kFilterPairs = 200;
constexpr double kRounding = 1e-7;  // relative: errors of the covariances' differences add up

// Four points, one of each kind: it stands; it moves, stops and moves; it is often unseen; it is
// another point from time to time, after a long interval.
class FilterTwins {
 public:
  explicit FilterTwins(FilterKernels kernels) : kernels_(kernels) { block_.updates[3] = 0.0; }

  void run() {
    for (pair_ = 0; pair_ < kFilterPairs && !::testing::Test::HasFailure(); ++pair_) {
      begin_pair();
      for (std::size_t lane = 0; lane < kFilterLanes; ++lane) {
        measurements_.is_seen[lane] = is_seen(lane) ? 1.0 : 0.0;
        if (is_seen(lane)) see(lane);
      }
      kernels_.step(step_, measurements_, block_, points_);
      for (std::size_t lane = 0; lane < kFilterLanes; ++lane) compare(lane);
    }
  }

  [[nodiscard]] double most_evidence(std::size_t lane) const { return most_evidence_[lane]; }

 private:
  [[nodiscard]] bool is_seen(std::size_t lane) const { return lane != 2 || pair_ % 3 != 1; }
  [[nodiscard]] bool jumps(std::size_t lane) const { return lane == 3 && pair_ % 50 == 49; }

  void begin_pair() {
    now_ += pair_ % 50 == 49 ? 20 * kFilterInterval : kFilterInterval;
    const double t_s = to_seconds(now_);
    Egomotion motion;
    motion.T_first_current.linear() = so3_exp({0.01, 0.2 * std::sin(t_s), 0.02 * t_s});
    motion.T_first_current.translation() << 0.1 * std::sin(t_s), 0.02, 0.5 * t_s;
    const Vector6d sigma{1e-3, 2e-3, 1e-3, 1e-4, 2e-4, 1e-4};
    motion.covariance_previous_current = sigma * sigma.transpose() * 0.3;
    motion.covariance_previous_current.diagonal() += sigma.cwiseAbs2();
    twin_.camera = kFilterCamera;
    twin_.rig = RigPose(motion);
    twin_.disparity_bias_px = 0.1;
    twin_.flow_error_share = 0.01;
    twin_.walk_px = 0.033;
    twin_.is_slow = jumps(3);
    step_ = filter_step(twin_.rig, kFilterCamera);
    step_.disparity_bias_px = 0.1;
    step_.flow_error_share = 0.01;
    step_.walk_px = 0.033;
    step_.prior = prior_;
    step_.now_ns = now_.count();
    step_.is_slow = twin_.is_slow;
  }

  void see(std::size_t lane) {
    std::normal_distribution<double> noise(0.0, 0.2);
    const bool moves = lane == 1 && (pair_ / 60) % 2 == 0;
    if (moves) place_m_[lane].x() += 0.03;
    if (jumps(lane)) place_m_[lane] += Eigen::Vector3d{0.2, 0.1, 3.0};
    const Eigen::Vector3d z_px =
        project(kFilterCamera, twin_.rig.T_current_first * place_m_[lane]) +
        Eigen::Vector3d{noise(random_), noise(random_), noise(random_)};
    Eigen::Matrix3d R_px2;
    R_px2 << 0.05, 0.01, 0.004, 0.01, 0.04, -0.003, 0.004, -0.003, 0.06;
    const double reanchored_px = pair_ % 31 == 30 ? 0.2 : 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) measurements_.uvd_px[i][lane] = z_px[i];
    const double lower[6] = {0.05, 0.01, 0.04, 0.004, -0.003, 0.06};
    for (std::size_t i = 0; i < 6; ++i) measurements_.covariance_px2[i][lane] = lower[i];
    measurements_.reanchored_px[lane] = reanchored_px;
    reference::step(twin_, prior_, now_, z_px, R_px2, reanchored_px, twins_[lane]);
    most_evidence_[lane] = std::max(most_evidence_[lane], twins_[lane].evidence);
  }

  void compare(std::size_t lane) const {
    const reference::TrackFilter& twin = twins_[lane];
    const auto near = [&](const char* what, double kernel, double wanted) {
      EXPECT_NEAR(kernel, wanted, kRounding * std::max(1.0, std::abs(wanted)))
          << what << ", lane " << lane << ", pair " << pair_;
    };
    near("updates", block_.updates[lane], twin.updates);
    near("evidence", block_.evidence[lane], twin.evidence);
    near("misfit", block_.misfit[lane], twin.misfit);
    near("stood", block_.stood[lane], twin.stood ? 1.0 : 0.0);
    near("fresh", static_cast<double>(block_.fresh_ns[lane]),
         static_cast<double>(twin.fresh.count()));
    if (twin.updates > 1) near("chi2", block_.standing_chi2[lane], twin.standing_chi2);
    if (!is_seen(lane)) return;
    const Eigen::Matrix3d R = twin_.rig.T_current_first.linear();
    const Eigen::Vector3d P_m = twin_.rig.T_current_first * twin.position_m();
    const Eigen::Vector3d v_mps = R * twin.velocity_mps();
    const Eigen::Matrix3d Cp = R * twin.moving.covariance.topLeftCorner<3, 3>() * R.transpose();
    const Eigen::Matrix3d V = twin.moving.covariance.bottomRightCorner<3, 3>();
    const Eigen::Matrix3d Cv = R * V * R.transpose();
    near("chi2", points_.chi2[lane], twin.velocity_mps().dot(V.inverse() * twin.velocity_mps()));
    for (Eigen::Index row = 0, at = 0; row < 3; ++row) {
      near("position", points_.position_m[row][lane], P_m[row]);
      near("velocity", points_.velocity_mps[row][lane], v_mps[row]);
      for (Eigen::Index column = 0; column <= row; ++column, ++at) {
        near("position covariance", points_.position_covariance_m2[at][lane], Cp(row, column));
        near("velocity covariance", points_.velocity_covariance_m2ps2[at][lane], Cv(row, column));
      }
    }
  }

  const FilterKernels kernels_;
  const MotionPrior prior_{};
  std::mt19937 random_{7};
  int pair_ = 0;
  Nanoseconds now_{0};
  reference::Camera twin_;
  FilterStep step_{};
  std::array<Eigen::Vector3d, kFilterLanes> place_m_{
      Eigen::Vector3d{0.5, 0.2, 6.0}, Eigen::Vector3d{-1.0, 0.1, 5.0},
      Eigen::Vector3d{1.0, -0.5, 8.0}, Eigen::Vector3d{-0.2, -0.3, 7.0}};
  std::array<reference::TrackFilter, kFilterLanes> twins_{};
  std::array<double, kFilterLanes> most_evidence_{};
  FilterBlock block_{};
  MeasurementBlock measurements_{};
  PointBlock points_{};
};

void check_filters(FilterKernels kernels) {
  FilterTwins twins(kernels);
  twins.run();
  EXPECT_LT(twins.most_evidence(0), 3.0) << "the scene must hold what stands";
  EXPECT_GT(twins.most_evidence(1), 20.0) << "and what moves";
  EXPECT_GT(twins.most_evidence(3), 3.0) << "and what leaves its place within a long interval";
}

TEST(FilterKernels, BaselineDoesWhatTheReferenceDoes) { check_filters(baseline::filter_kernels()); }

TEST(FilterKernels, ThoseChosenHereDoWhatTheReferenceDoes) { check_filters(filter_kernels()); }

}  // namespace
}  // namespace egomod
