// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/egomotion_estimator.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstring>

#include "../moving_objects/counted_new.hpp"
#include "egomotion_fixture.hpp"

namespace egomod {
namespace {

using synthetic::random_motion;
using synthetic::World;

class EgomotionEstimatorTest : public EgomotionTest {};
INSTANTIATE_TEST_SUITE_P(Variants, EgomotionEstimatorTest, all_variants(), variant_name);

TEST_P(EgomotionEstimatorTest, FindsRandomMotionsFromTheFirstPairOn) {
  std::mt19937 random(3);
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    World world(seed, 300);
    EgomotionEstimator estimator(config());
    Egomotion motion;
    estimator.estimate(world.tracks(), motion);
    EXPECT_EQ(motion.status, EstimateStatus::kFirst);
    const Eigen::Isometry3d T = se3_exp(random_motion(random, seed / 30.0, 0.35 * seed / 30.0));
    estimator.estimate(world.step(T, 1.0), motion);
    ASSERT_EQ(motion.status, EstimateStatus::kValid) << seed;
    const Vector6d e = error_of(motion, T);
    EXPECT_LT(e.head<3>().norm(), 0.02) << seed;
    EXPECT_LT(e.tail<3>().norm(), 0.004) << seed;
  }
}

TEST_P(EgomotionEstimatorTest, CovarianceIsHonest) {
  constexpr int kRuns = 200;
  // 95 % of chi-square with 1200 degrees of freedom, over 1200.
  constexpr double kLow = 0.9216;
  constexpr double kHigh = 1.0816;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    World world(seed, 250);
    EgomotionEstimator estimator(config());
    Egomotion motion;
    estimator.estimate(world.tracks(), motion);
    const Eigen::Isometry3d T = forward_and_left();
    estimator.estimate(world.step(T), motion);
    const Vector6d e = error_of(motion, T);
    sum += e.dot(motion.covariance_previous_current.inverse() * e);
  }
  EXPECT_GT(sum / (6 * kRuns), kLow);
  EXPECT_LT(sum / (6 * kRuns), kHigh);
}

TEST_P(EgomotionEstimatorTest, CovarianceStaysHonestInTheLongRun) {
  constexpr int kRuns = 60;
  constexpr int kPairs = 20;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    World world(seed, 150);
    EgomotionEstimator estimator(config());
    Egomotion motion;
    estimator.estimate(world.tracks(), motion);
    for (int k = 0; k < kPairs; ++k) estimator.estimate(world.step(forward_and_left()), motion);
    const Vector6d e = error_of(motion, forward_and_left());
    sum += e.dot(motion.covariance_previous_current.inverse() * e);
  }
  EXPECT_GT(sum / (6 * kRuns), 0.7);
  EXPECT_LT(sum / (6 * kRuns), 1.4);
}

TEST_P(EgomotionEstimatorTest, TwoInstancesGiveTheSameBytes) {
  EgomotionEstimator a(config());
  EgomotionEstimator b(config());
  World world(7, 400, 0.2, 0.1);
  Egomotion from_a;
  Egomotion from_b;
  for (int k = 0; k < 10; ++k) {
    a.estimate(world.tracks(), from_a);
    b.estimate(world.tracks(), from_b);
    EXPECT_EQ(std::memcmp(from_a.T_first_current.data(), from_b.T_first_current.data(),
                          sizeof(double) * 16),
              0);
    EXPECT_EQ(from_a.roles, from_b.roles);
    world.step(forward_and_left());
  }
}

TEST_P(EgomotionEstimatorTest, AllocatesNothingOnceWarm) {
  World world(8, 500, 0.2, 0.1);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 3; ++k) estimator.estimate(world.step(forward_and_left()), motion);
  for (int k = 0; k < 5; ++k) {
    const TrackSet& tracks = world.step(forward_and_left());
    const long before = allocations();
    estimator.estimate(tracks, motion);
    EXPECT_EQ(allocations(), before);
  }
}

TEST_P(EgomotionEstimatorTest, RotationStaysOrthonormalOverThousandsOfPairs) {
  World world(15, 60);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  Vector6d turn;
  turn << 0, 0, 0.02, 0, 0.05, 0.01;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 1000; ++k) estimator.estimate(world.step(se3_exp(turn)), motion);
  const Eigen::Matrix3d R = motion.T_first_current.linear();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

double drift_m(bool map) {
  EgomotionConfig config;
  config.map = map;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    World world(seed, 300);
    EgomotionEstimator estimator(config);
    Egomotion motion;
    estimator.estimate(world.tracks(), motion);
    for (int k = 0; k < 60; ++k) {
      const double sway = k / 10 % 2 == 0 ? 1.0 : -1.0;
      Vector6d xi;
      xi << 0.03 * sway, 0, 0.02, 0, 0.02 * sway, 0;
      estimator.estimate(world.step(se3_exp(xi)), motion);
    }
    sum += (motion.T_first_current.translation() - world.T_first_current().translation()).norm();
  }
  return sum / 10;
}

TEST(Egomotion, TheMapDriftsLessThanPairs) { EXPECT_LT(2 * drift_m(true), drift_m(false)); }

// NEES over its degrees of freedom of the motion in the last of two seconds, by how much the pose's
// covariance grows in it.
double growth_nees(const EgomotionConfig& config, const Eigen::Isometry3d& T_previous_current) {
  constexpr int kRuns = 30;
  constexpr int kPairsPerS = 30;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    World world(seed, 150);
    EgomotionEstimator estimator(config);
    Egomotion begin;
    Egomotion end;
    estimator.estimate(world.tracks(), end);
    for (int k = 0; k < 2 * kPairsPerS; ++k) {
      if (k == kPairsPerS) begin = end;
      estimator.estimate(world.step(T_previous_current, 1.0 / kPairsPerS), end);
    }
    const Eigen::Isometry3d to_truth = se3_exp(kPairsPerS * se3_log(T_previous_current));
    const Eigen::Isometry3d T_begin_end = begin.T_first_current.inverse() * end.T_first_current;
    const Vector6d e = se3_log(T_begin_end.inverse() * to_truth);
    const Matrix6d Ad = adjoint(T_begin_end.inverse());
    const Matrix6d growth =
        end.covariance_first_current - Ad * begin.covariance_first_current * Ad.transpose();
    sum += e.dot(growth.inverse() * e);
  }
  return sum / (6 * kRuns);
}

// Tracks that err independently from pair to pair, as here, err less in a second than those of
// images, whose errors wander: the growth allows for that.
TEST(Egomotion, AgainstTheMapThePosesCovarianceGrowsByThatOfTheMotionInASecond) {
  for (const double speed_m : {0.0, 0.3}) {
    const Eigen::Isometry3d T_previous_current(Eigen::Translation3d(0.0, 0.0, speed_m / 30.0));
    const double nees = growth_nees(EgomotionConfig{}, T_previous_current);
    EXPECT_GT(nees, 0.3) << speed_m << " m/s";
    EXPECT_LT(nees, 1.5) << speed_m << " m/s";
  }
}

// How much the pose's covariance grows in 2 s of which each pair's rows are displaced to and fro.
double growth_m2(double shear_px) {
  World world(1, 600);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 60; ++k) {
    TrackSet tracks = world.step(forward_and_left(), 1.0 / 30.0);
    const double shear = shear_px * std::sin(0.3 * k);
    for (Track& track : tracks.tracks) {
      const double row = double{track.current.v_px} / synthetic::kCamera.height_px;
      track.current.u_px += static_cast<float>(shear * (row - 0.5));
    }
    estimator.estimate(tracks, motion);
  }
  return motion.covariance_first_current.topLeftCorner<3, 3>().trace();
}

TEST(Egomotion, ThePosesCovarianceGrowsFasterWherePointsErrTogether) {
  EXPECT_GT(growth_m2(0.8), 2.0 * growth_m2(0.0));
}

TEST(Egomotion, BothMethodsAgreeWithinTheirCovariances) {
  double sum = 0.0;
  constexpr int kRuns = 50;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    std::array<Egomotion, 2> motions;
    for (const auto method :
         {EgomotionMethod::kGaussNewton, EgomotionMethod::kSigmaPointKalmanFilter}) {
      EgomotionConfig config;
      config.method = method;
      config.map = false;
      World world(seed, 250);
      EgomotionEstimator estimator(config);
      Egomotion& motion = motions[method == EgomotionMethod::kGaussNewton ? 0 : 1];
      estimator.estimate(world.tracks(), motion);
      estimator.estimate(world.step(forward_and_left()), motion);
    }
    const Vector6d d = error_of(motions[0], motions[1].T_previous_current);
    const Matrix6d C =
        motions[0].covariance_previous_current + motions[1].covariance_previous_current;
    sum += d.dot(C.inverse() * d);
  }
  EXPECT_LT(sum / (6 * kRuns), 1.0);
}

}  // namespace
}  // namespace egomod
