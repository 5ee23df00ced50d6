// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "egomotion_fixture.hpp"

namespace egomod {
namespace {

using synthetic::World;

class EgomotionFaultsTest : public EgomotionTest {};
INSTANTIATE_TEST_SUITE_P(Variants, EgomotionFaultsTest, all_variants(), variant_name);

bool finite(const Egomotion& motion) {
  return motion.T_previous_current.matrix().allFinite() &&
         motion.T_first_current.matrix().allFinite() &&
         motion.covariance_previous_current.allFinite() &&
         motion.covariance_first_current.allFinite() && std::isfinite(motion.residual_px);
}

TEST_P(EgomotionFaultsTest, TooFewTracksFailAndRepeatThePose) {
  World world(9, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  const Eigen::Isometry3d before = motion.T_first_current;
  TrackSet few = world.step(forward_and_left());
  few.tracks.resize(5);
  estimator.estimate(few, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  EXPECT_EQ(motion.reason, EstimateReason::kFewTracks);
  EXPECT_EQ(motion.T_first_current.matrix(), before.matrix());
  EXPECT_TRUE(finite(motion));
}

// Points of the world replaced by what `place` makes of them, seen without noise from rest.
template <typename Place>
Egomotion estimate_placed(const EgomotionConfig& config, const Place& place) {
  World world(10, 200);
  EgomotionEstimator estimator(config);
  Egomotion motion;
  std::mt19937 random(1);
  for (int k = 0; k < 2; ++k) {
    TrackSet tracks = k == 0 ? world.tracks() : world.step(Eigen::Isometry3d::Identity());
    for (Track& track : tracks.tracks) {
      const auto id = static_cast<double>(track.id);
      track.previous = synthetic::observe(place(id), world.noise, random);
      track.current = synthetic::observe(place(id), world.noise, random);
    }
    estimator.estimate(tracks, motion);
  }
  return motion;
}

TEST_P(EgomotionFaultsTest, PointsOnALineAreDegenerate) {
  const Egomotion motion = estimate_placed(
      config(), [](double id) { return Eigen::Vector3d(-1.5 + 0.015 * id, 0.2, 4.0); });
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  EXPECT_EQ(motion.reason, EstimateReason::kDegenerate);
  EXPECT_TRUE(finite(motion));
}

TEST_P(EgomotionFaultsTest, PointsTooFarAwayDoNotFixTranslation) {
  const Egomotion motion = estimate_placed(config(), [](double id) {
    return Eigen::Vector3d(200 * std::sin(id), 150 * std::sin(2.7 * id), 900.0);
  });
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  EXPECT_TRUE(finite(motion));
}

TEST_P(EgomotionFaultsTest, GarbageIsNeverPassedOn) {
  World world(11, 200);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int k = 0; k < 6; ++k) {
    TrackSet tracks = world.step(forward_and_left());
    for (std::size_t i = 0; i < tracks.tracks.size(); i += 3) {
      Track& track = tracks.tracks[i];
      if (k == 1) track.current.u_px = nan;
      if (k == 2) track.previous.disparity_px = nan;
      if (k == 3) track.current.disparity_px = -4.0F;
      if (k == 4) track.current.covariance_px2.fill(nan);
      if (k == 5) track.previous.covariance_px2.fill(0.0F);
    }
    estimator.estimate(tracks, motion);
    EXPECT_TRUE(finite(motion)) << k;
    EXPECT_EQ(motion.status, EstimateStatus::kValid) << k;
    EXPECT_LT(error_of(motion, forward_and_left()).norm(), 0.05) << k;
  }
}

TEST_P(EgomotionFaultsTest, SkippedPairsRepeatThePoseAndTheNextOneCoversThem) {
  World world(12, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  const Eigen::Isometry3d before = motion.T_first_current;
  const Nanoseconds exposure = motion.exposure;
  TrackSet skipped;
  skipped.sequence = 2;
  skipped.exposure = exposure + std::chrono::milliseconds(50);
  skipped.status = TrackStatus::kNotRun;
  skipped.pair_status = PairStatus::kSkipped;
  estimator.estimate(skipped, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kSkipped);
  EXPECT_EQ(motion.T_first_current.matrix(), before.matrix());
  TrackSet next = world.step(forward_and_left());
  next.sequence = 3;
  estimator.estimate(next, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kValid);
  EXPECT_EQ(motion.reason, EstimateReason::kNone);
  EXPECT_EQ(motion.previous_exposure, exposure);
  EXPECT_LT(error_of(motion, forward_and_left()).norm(), 0.01);
}

TEST_P(EgomotionFaultsTest, RejectedPairsFailAndAreComposedOver) {
  World world(13, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  TrackSet rejected;
  rejected.sequence = 1;
  rejected.status = TrackStatus::kNotRun;
  rejected.pair_status = PairStatus::kRejected;
  estimator.estimate(rejected, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  EXPECT_EQ(motion.reason, EstimateReason::kPairRejected);
  EXPECT_GE(motion.covariance_first_current(0, 0), 0.25) << "it may have gone anywhere";
  EXPECT_GE(motion.covariance_previous_current(0, 0), 0.25);
  TrackSet next = world.step(forward_and_left());
  next.sequence = 2;
  estimator.estimate(next, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kValid);
  EXPECT_EQ(motion.reason, EstimateReason::kHole);
  EXPECT_LT(error_of(motion, forward_and_left()).norm(), 0.01);
  EXPECT_LT(motion.covariance_first_current(0, 0), 0.01) << "and now it is known where";
}

// Images that never came leave no gap in the numbers.
TEST_P(EgomotionFaultsTest, APairThatComesLateIsComposedOverAHoleAndThoseAfterItAreNot) {
  World world(20, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 4; ++k) estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.reason, EstimateReason::kNone);
  const Eigen::Isometry3d over_two = forward_and_left() * forward_and_left();
  estimator.estimate(world.step(over_two, 0.2), motion);
  EXPECT_EQ(motion.status, EstimateStatus::kValid);
  EXPECT_EQ(motion.reason, EstimateReason::kHole);
  EXPECT_LT(error_of(motion, over_two).norm(), 0.01);
  estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.reason, EstimateReason::kNone);
}

// The word waits for the first motion that is found.
TEST_P(EgomotionFaultsTest, AHoleThatEndsInTheDarkIsStillAHole) {
  World world(21, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 4; ++k) estimator.estimate(world.step(forward_and_left()), motion);
  TrackSet dark = world.step(forward_and_left() * forward_and_left(), 0.2);
  for (Track& track : dark.tracks) track.has_current = false;
  estimator.estimate(dark, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.status, EstimateStatus::kValid);
  EXPECT_EQ(motion.reason, EstimateReason::kHole);
}

TEST_P(EgomotionFaultsTest, AReseedCountsAResetAndKeepsThePoseUncertain) {
  World world(14, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  const Eigen::Isometry3d before = motion.T_first_current;
  TrackSet reseeded = world.step(forward_and_left());
  reseeded.status = TrackStatus::kReseeded;
  estimator.estimate(reseeded, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFirst);
  EXPECT_EQ(motion.reason, EstimateReason::kReseeded);
  EXPECT_EQ(motion.reset_count, 1U);
  EXPECT_EQ(motion.T_first_current.matrix(), before.matrix());
  EXPECT_GT(motion.covariance_first_current(0, 0), 0.5);
  estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.status, EstimateStatus::kValid);
  EXPECT_EQ(motion.reset_count, 1U);
  EXPECT_GT(motion.covariance_first_current(0, 0), 0.5);
}

// Estimates `pairs` more pairs; how many of them had no valid motion before the last.
int pairs_until_valid(World& world, int pairs, EgomotionEstimator& estimator, Egomotion& motion) {
  int invalid = 0;
  for (int k = 0; k < pairs; ++k) {
    estimator.estimate(world.step(forward_and_left()), motion);
    if (motion.status != EstimateStatus::kValid) invalid = k + 1;
  }
  return invalid;
}

TEST_P(EgomotionFaultsTest, TracksThatAreAllNewAreCutOffAndRecoverWithinTwoPairs) {
  World world(15, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  TrackSet dark = world.step(forward_and_left());
  dark.status = TrackStatus::kFew;
  dark.tracks.resize(3);
  estimator.estimate(dark, motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFailed);
  world.lose_all();
  EXPECT_LE(pairs_until_valid(world, 6, estimator, motion), 2);
  EXPECT_EQ(motion.reset_count, config().map ? 1U : 0U);
  EXPECT_LT(error_of(motion, forward_and_left()).norm(), 0.01);
}

TEST_P(EgomotionFaultsTest, ANewCalibrationStartsAnewAndGoesOn) {
  World world(16, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  world.tracks().camera.baseline_m *= 1.1;
  estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFirst);
  EXPECT_EQ(motion.reason, EstimateReason::kRecalibrated);
  EXPECT_EQ(motion.reset_count, 1U);
  EXPECT_EQ(pairs_until_valid(world, 5, estimator, motion), 0);
}

TEST_P(EgomotionFaultsTest, ACutThatIsTooDarkToSeedIsStillACut) {
  World world(17, 300);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  TrackSet dark = world.step(forward_and_left());
  dark.status = TrackStatus::kFew;
  dark.discontinuity = true;
  dark.tracks.resize(3);
  estimator.estimate(dark, motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  EXPECT_EQ(motion.status, EstimateStatus::kFirst);
  EXPECT_EQ(motion.reason, EstimateReason::kReseeded);
  EXPECT_EQ(motion.reset_count, 1U);
}

TEST_P(EgomotionFaultsTest, AMapThatEveryPairContradictsIsGivenUp) {
  World before(18, 300);
  World after(19, 300);  // other points under the same names
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(before.tracks(), motion);
  for (int k = 0; k < 10; ++k) estimator.estimate(before.step(forward_and_left()), motion);
  for (int k = 0; k < 10; ++k) {
    after.step(forward_and_left());
    before.step(forward_and_left());
  }
  after.tracks().sequence = before.tracks().sequence;
  after.tracks().exposure = before.tracks().exposure;
  EXPECT_LE(pairs_until_valid(after, 12, estimator, motion), 6);
  EXPECT_LT(error_of(motion, forward_and_left()).norm(), 0.01);
}

}  // namespace
}  // namespace egomod
