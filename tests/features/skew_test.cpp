// SPDX-License-Identifier: Apache-2.0
#include "skew.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "egomod/core/geometry.hpp"
#include "test_camera.hpp"

namespace egomod {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kInterval{33};
constexpr double kInterval_s = 0.033;
constexpr float kRounding_px = 2e-3F;

// Of the scene against the camera: the rig turns right at 40 degrees a second and drives ahead.
Vector6d turning_velocity() {
  Vector6d velocity;
  velocity << 0.1, 0.02, -0.5, 0.02, -0.7, 0.01;
  return velocity;
}

const std::vector<Eigen::Vector3d> kPoints_m{
    {-1.5, -0.8, 3.0}, {0.0, 0.0, 2.0}, {1.0, 0.9, 4.0}, {3.0, -2.0, 9.0}, {-0.4, 0.3, 1.2}};

ImagePoint left_of(const Eigen::Vector3d& P_m) {
  const Eigen::Vector3d uvd = project(kCamera, P_m);
  return {static_cast<float>(uvd.x()), static_cast<float>(uvd.y())};
}
float disparity_of(const Eigen::Vector3d& P_m) {
  return static_cast<float>(project(kCamera, P_m).z());
}
ImagePoint right_of(const Eigen::Vector3d& P_m) {
  const ImagePoint left = left_of(P_m);
  return {left.u_px - disparity_of(P_m), left.v_px};
}

void expect_shift_between(const Skew& skew, const Eigen::Vector3d& P_now_m,
                          const Eigen::Vector3d& P_later_m) {
  const ImagePoint shift = skew.shift(left_of(P_now_m), disparity_of(P_now_m));
  const ImagePoint truth = right_of(P_later_m) - right_of(P_now_m);
  EXPECT_NEAR(shift.u_px, truth.u_px, kRounding_px);
  EXPECT_NEAR(shift.v_px, truth.v_px, kRounding_px);
}

TEST(SkewTest, ShiftsRestingPointsByWhatTheRigMovesUntilTheRightExposure) {
  for (const int skew_ms : {10, -10, 3}) {
    Skew skew;
    skew.begin_pair(kCamera, milliseconds(skew_ms), kInterval, true);
    skew.move(se3_exp(kInterval_s * turning_velocity()));
    const Eigen::Isometry3d T_later_now = se3_exp(1e-3 * skew_ms * turning_velocity());
    for (const Eigen::Vector3d& P : kPoints_m) expect_shift_between(skew, P, T_later_now * P);
  }
}

// A yaw rate that grows evenly: the mean over the last interval is not that of the skew.
TEST(SkewTest, CarriesAnEvenChangeOfTheMotionOn) {
  constexpr double kTurn_radps = 0.5, kTurnAcceleration_radps2 = 3.0, kSkew_s = 0.01;
  const auto turned_between = [&](double from_s, double to_s) {
    const double angle = kTurn_radps * (to_s - from_s) +
                         0.5 * kTurnAcceleration_radps2 * (to_s * to_s - from_s * from_s);
    Vector6d xi = Vector6d::Zero();
    xi[4] = -angle;
    return se3_exp(xi);
  };
  Skew skew;
  skew.begin_pair(kCamera, milliseconds(10), kInterval, true);
  skew.move(turned_between(-2 * kInterval_s, -kInterval_s));
  skew.begin_pair(kCamera, milliseconds(10), kInterval, true);
  skew.move(turned_between(-kInterval_s, 0.0));
  for (const Eigen::Vector3d& P : kPoints_m)
    expect_shift_between(skew, P, turned_between(0.0, kSkew_s) * P);
  EXPECT_GT(skew.variance_px2(20.0F), 0.0F);
}

TEST(SkewTest, WithoutSkewNothingIsShiftedNorUncertain) {
  Skew skew;
  skew.begin_pair(kCamera, milliseconds(0), kInterval, true);
  skew.move(se3_exp(kInterval_s * turning_velocity()));
  EXPECT_TRUE(skew.none());
  EXPECT_EQ(skew.shift({100.0F, 50.0F}, 30.0F).u_px, 0.0F);
  EXPECT_EQ(skew.own_shift({4.0F, -3.0F}).v_px, 0.0F);
  EXPECT_EQ(skew.variance_px2(30.0F), 0.0F);
  skew.move(std::nullopt);
  EXPECT_EQ(skew.variance_px2(30.0F), 0.0F);
}

TEST(SkewTest, AnUnknownMotionShiftsNothingAndLeavesDisparitiesUncertain) {
  Skew skew;
  skew.begin_pair(kCamera, milliseconds(10), kInterval, false);
  skew.move(std::nullopt);
  EXPECT_EQ(skew.shift({100.0F, 50.0F}, 30.0F).u_px, 0.0F);
  EXPECT_GT(std::sqrt(skew.variance_px2(30.0F)), 2.0F);
}

// Steady motion is carried on without doubt.
TEST(SkewTest, ASteadyMotionLeavesNoUncertainty) {
  Skew skew;
  for (int k = 0; k < 2; ++k) {
    skew.begin_pair(kCamera, milliseconds(10), kInterval, true);
    skew.move(se3_exp(kInterval_s * turning_velocity()));
  }
  EXPECT_LT(skew.variance_px2(30.0F), 1e-8F);
}

// Disparities found with `skew` when the rig turned by `extra` more than it tells; `noise_px` of
// either sign, a fifth of them wrong.
std::vector<Skew::Surprise> surprises(const Skew& skew, const Eigen::Isometry3d& T_extra,
                                      double noise_px) {
  std::vector<Skew::Surprise> all;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> across(-0.5, 0.5), depth_m(1.5, 9.0);
  std::normal_distribution<double> noise(0.0, noise_px);
  for (int i = 0; i < 150; ++i) {
    const double z = depth_m(random);
    const Eigen::Vector3d P(across(random) * z, 0.8 * across(random) * z, z);
    const ImagePoint extra = right_of(T_extra * P) - right_of(P);
    const double wrong_px = i % 5 == 0 ? 6.0 * across(random) : 0.0;
    all.push_back(
        {left_of(P), disparity_of(P), static_cast<float>(noise(random) + wrong_px) - extra.u_px});
  }
  EXPECT_FALSE(skew.none());
  return all;
}

Skew steady_skew() {
  Skew skew;
  for (int k = 0; k < 2; ++k) {
    skew.begin_pair(kCamera, milliseconds(10), kInterval, true);
    skew.move(se3_exp(kInterval_s * turning_velocity()));
  }
  return skew;
}

// 0.4 rad/s more from one pair to the next, as where a robot's base starts to turn.
TEST(SkewTest, DisparitiesThatAllSurpriseTellASuddenTurn) {
  Skew skew = steady_skew();
  Vector6d extra = Vector6d::Zero();
  extra[4] = -0.004;
  skew.turn(surprises(skew, se3_exp(extra), 0.15));
  const Eigen::Isometry3d T_later_now = se3_exp(extra) * se3_exp(0.01 * turning_velocity());
  constexpr float kMaxError_px = 0.1F;
  for (const Eigen::Vector3d& P : kPoints_m) {
    const ImagePoint shift = skew.shift(left_of(P), disparity_of(P));
    EXPECT_NEAR(shift.u_px, (right_of(T_later_now * P) - right_of(P)).u_px, kMaxError_px);
  }
  EXPECT_GT(skew.variance_px2(30.0F), 0.0F);
}

TEST(SkewTest, ASurpriseThatLastsTellsNoTurn) {
  Vector6d extra = Vector6d::Zero();
  extra[4] = -0.002;
  Skew skew = steady_skew();
  float shift_px = 0.0F;
  for (int k = 0; k < 4; ++k) {
    skew.begin_pair(kCamera, milliseconds(10), kInterval, true);
    skew.move(se3_exp(kInterval_s * turning_velocity()));
    const float steady_px = skew.shift({100.0F, 50.0F}, 30.0F).u_px;
    skew.turn(surprises(skew, se3_exp(extra), 0.15));
    shift_px = skew.shift({100.0F, 50.0F}, 30.0F).u_px;
    EXPECT_EQ(shift_px != steady_px, k < 3) << k;
  }
}

TEST(SkewTest, NoiseTellsNoTurn) {
  Skew skew = steady_skew();
  const ImagePoint before = skew.shift({100.0F, 50.0F}, 30.0F);
  skew.turn(surprises(skew, Eigen::Isometry3d::Identity(), 0.25));
  EXPECT_EQ(skew.shift({100.0F, 50.0F}, 30.0F).u_px, before.u_px);
  skew.turn({});
  EXPECT_EQ(skew.shift({100.0F, 50.0F}, 30.0F).u_px, before.u_px);
}

TEST(SkewTest, AMoverShiftsByItsOwnMotionAndNoiseDoesNot) {
  Skew skew;
  skew.begin_pair(kCamera, milliseconds(11), kInterval, true);
  skew.move(Eigen::Isometry3d::Identity());
  EXPECT_NEAR(skew.own_shift({9.0F, 0.0F}).u_px, 3.0F, 0.05F);
  EXPECT_NEAR(skew.own_shift({0.0F, -9.0F}).v_px, -3.0F, 0.05F);
  EXPECT_LT(skew.own_shift({0.15F, 0.0F}).u_px, 0.003F);
}

}  // namespace
}  // namespace egomod
