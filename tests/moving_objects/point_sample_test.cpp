// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/point_sample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "egomod/core/geometry.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::kCamera;
using synthetic::World;

// Observations are stored in single precision: 3e-5 px at 640, which is 1e-4 m/s at 3 m and 5 Hz.
constexpr double kStored_mps = 1e-3;

TEST(PointSample, VelocityIsExactFromAMovingRig) {
  World world;
  world.rate_hz = 5.0;
  world.rig_velocity_mps = {0.1, 0.0, 0.7};
  world.rig_yaw_rate_radps = 0.3;
  world.points = {{{0.3, -0.2, 3.0}, {0.4, 0.1, -0.3}}, {{-0.5, 0.2, 2.5}, {0, 0, 0}}};
  (void)world.tracks(3);
  const TrackSet tracks = world.tracks(4);
  const Egomotion motion = world.motion(tracks, 4);
  const Step step{.T_current_reference = motion.T_previous_current.inverse(), .duration_s = 0.2};
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const Track& track = tracks.tracks[i];
    const PointSample sample = measure_point(kCamera, track.previous, track.current, step);
    EXPECT_LT((sample.velocity_mps - world.velocity_in_camera(i, 4)).norm(), kStored_mps);
    EXPECT_LT((sample.position_m - world.in_camera(i, 4)).norm(), kStored_mps);
  }
}

TEST(PointSample, MotionJacobianAgreesWithFiniteDifferences) {
  const StereoObservation reference{400.0F, 200.0F, 50.0F, {0.04F, 0, 0, 0.04F, 0, 0.06F}};
  const StereoObservation current{390.0F, 205.0F, 52.0F, {0.04F, 0, 0, 0.04F, 0, 0.06F}};
  Vector6d pose;
  pose << 0.1, -0.05, 0.3, 0.02, -0.03, 0.01;
  const Eigen::Isometry3d T_reference_current = se3_exp(pose);
  const Eigen::Isometry3d T_current_reference = T_reference_current.inverse();
  const Residual residual =
      static_residual(kCamera, reference, current, {.T_current_reference = T_current_reference});
  const double h = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const auto value = [&](double step) {
      const Vector6d xi = step * Vector6d::Unit(k);
      return static_residual(kCamera, reference, current,
                             {.T_current_reference = (T_reference_current * se3_exp(xi)).inverse()})
          .value_px;
    };
    EXPECT_LT((residual.motion_jacobian.col(k) - (value(h) - value(-h)) / (2 * h)).norm(), 1e-4);
  }
}

TEST(PointSample, WhitenedStaticDisplacementFollowsChiSquare) {
  World world(11);
  world.add_background(1500);
  world.pixel_sigma = 0.2;
  world.disparity_sigma_px = 0.25;
  (void)world.tracks(0);
  const TrackSet tracks = world.tracks(1);
  const Step step{.T_current_reference = world.motion(tracks, 1).T_previous_current.inverse(),
                  .duration_s = 1 / 30.0};
  double sum = 0.0;
  int count = 0;
  for (const Track& track : tracks.tracks) {
    if (!track.has_current || !track.has_previous) continue;
    sum += measure_point(kCamera, track.previous, track.current, step).chi2;
    ++count;
  }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(sum / count, 3.0, 4 * std::sqrt(6.0 / count));
}

TEST(PointSample, NoiseAloneSpeaksForStaticAndMotionForMoving) {
  const Eigen::Matrix3d covariance = 0.01 * Eigen::Matrix3d::Identity();
  EXPECT_LT(motion_log_ratio({0.1, 0.0, 0.1}, covariance, 1.5), -2.0);
  EXPECT_GT(motion_log_ratio({0.6, 0.0, 0.3}, covariance, 1.5), 5.0);
}

TEST(PointSample, ObservationsThatCannotBeMeasuredAreNotUsable) {
  const StereoObservation good{400.0F, 200.0F, 50.0F, {0.04F, 0, 0, 0.04F, 0, 0.06F}};
  EXPECT_TRUE(is_usable(kCamera, good, 40.0));
  StereoObservation bad = good;
  bad.disparity_px = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(is_usable(kCamera, bad, 40.0));
  bad.disparity_px = 0.0F;
  EXPECT_FALSE(is_usable(kCamera, bad, 40.0));
  bad.disparity_px = -3.0F;
  EXPECT_FALSE(is_usable(kCamera, bad, 40.0));
  bad = good;
  bad.covariance_px2[5] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(is_usable(kCamera, bad, 40.0));
  EXPECT_FALSE(is_usable(kCamera, good, 3.0)) << "3.9 m away";
}

}  // namespace
}  // namespace egomod
