// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/readout.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "egomod/egomotion/egomotion_estimator.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;
using synthetic::World;

constexpr double kDtS = 1.0 / 30.0;
constexpr double kReadoutS = 0.025;

// A rig that drives on while it swings to and fro and nods.
Vector6d velocity_at(double t_s) {
  Vector6d velocity;
  velocity << 0.0, 0.0, 0.4, 0.1 * std::cos(4.0 * t_s), 0.3 * std::sin(3.0 * t_s), 0.0;
  return velocity;
}

TrackSet as_rows_show(TrackSet tracks, double readout_s, const Vector6d& velocity) {
  for (Track& track : tracks.tracks) {
    const Eigen::Vector3d P = triangulate(kCamera, uvd(track.current));
    const Eigen::Vector3f by =
        (readout_s * row_displacement_per_s(kCamera, P, velocity)).cast<float>();
    track.current.u_px += by.x();
    track.current.v_px += by.y();
    track.current.disparity_px += by.z();
  }
  return tracks;
}

struct Ride {
  double readout_s;
  double error_m;  // at the end
  double rotation_error_rad;
  double nees;  // of the motion in the last second, over its degrees of freedom
};

Ride ride(std::uint32_t seed, double readout_s) {
  constexpr int kPairs = 120;
  World world(seed, 600, 0.0, 0.02);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  Egomotion before;
  Eigen::Isometry3d T_before;
  estimator.estimate(as_rows_show(world.tracks(), readout_s, velocity_at(0.0)), motion);
  for (int k = 1; k <= kPairs; ++k) {
    const Vector6d mean_velocity = velocity_at((k - 0.5) * kDtS);
    const TrackSet& tracks = world.step(se3_exp(kDtS * mean_velocity), kDtS);
    estimator.estimate(as_rows_show(tracks, readout_s, velocity_at(k * kDtS)), motion);
    if (k != kPairs - 30) continue;
    before = motion;
    T_before = world.T_first_current();
  }
  const Vector6d error = se3_log(motion.T_first_current.inverse() * world.T_first_current());
  const Eigen::Isometry3d T_second = before.T_first_current.inverse() * motion.T_first_current;
  const Vector6d second =
      se3_log(T_second.inverse() * T_before.inverse() * world.T_first_current());
  const Matrix6d Ad = adjoint(T_second.inverse());
  const Matrix6d growth =
      motion.covariance_first_current - Ad * before.covariance_first_current * Ad.transpose();
  return {motion.rows.readout_s, error.head<3>().norm(), error.tail<3>().norm(),
          second.dot(growth.inverse() * second) / 6};
}

TEST(Readout, IsLearntAndTheMotionIsThatOfTheMiddleRow) {
  double nees = 0.0;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const Ride rolling = ride(seed, kReadoutS);
    EXPECT_NEAR(rolling.readout_s, kReadoutS, 0.05 * kReadoutS);
    EXPECT_LT(rolling.error_m, 0.005) << "of 1.6 m";
    EXPECT_LT(rolling.rotation_error_rad, 0.002);
    nees += rolling.nees / 6;
  }
  EXPECT_LT(nees, 2.0);
}

TEST(Readout, OfAGlobalShutterIsNone) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) EXPECT_EQ(ride(seed, 0.0).readout_s, 0.0);
}

TEST(Readout, IsNotForgottenAtRest) {
  constexpr int kDriven = 120;
  constexpr int kInAll = kDriven + 90 * 30;
  World world(1, 300, 0.0, 0.02);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  const auto velocity = [&](int k) -> Vector6d {
    return k < kDriven ? velocity_at(k * kDtS) : Vector6d::Zero();
  };
  estimator.estimate(as_rows_show(world.tracks(), kReadoutS, velocity(0)), motion);
  for (int k = 1; k <= kInAll; ++k) {
    const TrackSet& tracks =
        world.step(se3_exp(0.5 * kDtS * (velocity(k - 1) + velocity(k))), kDtS);
    estimator.estimate(as_rows_show(tracks, kReadoutS, velocity(k)), motion);
    if (k == kDriven) {
      ASSERT_NEAR(motion.rows.readout_s, kReadoutS, 0.05 * kReadoutS);
    }
  }
  EXPECT_NEAR(motion.rows.readout_s, kReadoutS, 0.05 * kReadoutS);
}

TEST(Readout, TheVelocityAtAPairFollowsALine) {
  PairVelocity velocity;
  const auto mean = [](double t_s) -> Vector6d { return Vector6d::Constant(2.0 + 3.0 * t_s); };
  EXPECT_EQ(velocity.after(mean(0.5)), mean(0.5));
  velocity.keep(mean(0.5));
  EXPECT_LT((velocity.after(mean(1.5)) - mean(2.0)).norm(), 1e-12);
  velocity.keep(mean(1.5));
  EXPECT_LT((velocity.after(mean(2.5)) - mean(3.0)).norm(), 1e-12);
}

// A turn of 0.5 rad/s that sets off half-way between two pairs.
TEST(PairVelocity, DoesNotShootBeyondATurnThatSetsOffAtOnce) {
  const auto yaw = [](double radps) -> Vector6d { return radps * Vector6d::Unit(4); };
  PairVelocity velocity;
  velocity.keep(yaw(0.0));
  velocity.keep(yaw(0.0));
  EXPECT_NEAR(velocity.after(yaw(0.25))[4], 0.25, 1e-12) << "nothing says how it goes on";
  velocity.keep(yaw(0.25));
  EXPECT_NEAR(velocity.after(yaw(0.5))[4], 0.625, 1e-12);
  velocity.keep(yaw(0.5));
  EXPECT_NEAR(velocity.after(yaw(0.5))[4], 0.5, 1e-12);
}

}  // namespace
}  // namespace egomod
