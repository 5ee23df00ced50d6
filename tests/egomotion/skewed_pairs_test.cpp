// SPDX-License-Identifier: Apache-2.0
// Features and egomotion together, where the right camera is exposed before or after the left one.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod {
namespace {

using std::chrono::milliseconds;

constexpr double kRate_hz = 30.0;
constexpr int kPairs = 54;  // a swing to one side and back
constexpr double kTurn_radps = 40.0 / 180.0 * M_PI;
constexpr double kSwingPeriod_s = 2.0;
constexpr double kSpeed_mps = 0.4;
constexpr double kMaxErrorRatio = 1.5;  // to that of cameras that expose together
constexpr double kErrorOfChance_m = 0.001;
constexpr double kUncorrectedError_m = 0.005;

test_support::Scene swinging_rig() {
  test_support::Scene scene = test_support::furnished_room();
  scene.T_world_camera = [](double t_s) {
    const double rate = 2.0 * M_PI / kSwingPeriod_s;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation().z() = kSpeed_mps * t_s;
    T.rotate(Eigen::AngleAxisd(kTurn_radps / rate * (1.0 - std::cos(rate * t_s)),
                               Eigen::Vector3d::UnitY()));
    return T;
  };
  return scene;
}

struct Outcome {
  double error_m = 0.0;  // of the position, mean over the last half
  int invalid = 0;
};

// `told`: the skew that the pairs admit.
Outcome drive(const std::function<Nanoseconds(int)>& skew,
              const std::function<Nanoseconds(int)>& told) {
  const test_support::SyntheticWorld world(swinging_rig(), test_support::kinect_pair(320),
                                           {.noise_sigma = 1.0});
  FeatureTracker tracker{FeaturesConfig{}};
  EgomotionEstimator estimator{EgomotionConfig{}};
  TrackSet tracks;
  Egomotion motion;
  Outcome outcome;
  Image unused;
  for (int k = 0; k < kPairs; ++k) {
    StereoPair pair;
    pair.sequence = static_cast<std::uint64_t>(k);
    const double t_s = k / kRate_hz;
    pair.exposure = Nanoseconds(std::llround(t_s * 1e9));
    pair.right_exposure = pair.exposure + told(k);
    pair.calibration.camera = world.camera();
    world.render(t_s, pair.left, pair.right);
    if (skew(k) != Nanoseconds(0)) world.render(t_s + to_seconds(skew(k)), unused, pair.right);
    tracker.track(pair, tracks);
    estimator.estimate(tracks, motion);
    outcome.invalid += motion.status == EstimateStatus::kFailed ? 1 : 0;
    if (2 * k < kPairs) continue;
    const Eigen::Isometry3d error = world.T_first_current(t_s).inverse() * motion.T_first_current;
    outcome.error_m += error.translation().norm() / (kPairs - kPairs / 2);
  }
  return outcome;
}

Outcome drive(const std::function<Nanoseconds(int)>& skew) { return drive(skew, skew); }

Nanoseconds none(int) { return Nanoseconds(0); }

class SkewedPairsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { together_ = drive(none); }
  static void expect_as_good_as_together(const Outcome& skewed) {
    EXPECT_EQ(skewed.invalid, 0);
    EXPECT_LT(skewed.error_m, kMaxErrorRatio * together_.error_m + kErrorOfChance_m);
  }
  static inline Outcome together_;
};

TEST_F(SkewedPairsTest, a_late_right_camera_costs_hardly_any_accuracy) {
  expect_as_good_as_together(drive([](int) { return milliseconds(10); }));
}

TEST_F(SkewedPairsTest, an_early_right_camera_costs_hardly_any_accuracy) {
  expect_as_good_as_together(drive([](int) { return milliseconds(-10); }));
}

// Clocks that run apart: from nearly half an interval before to as much after the left exposure.
TEST_F(SkewedPairsTest, a_skew_that_wanders_is_followed) {
  expect_as_good_as_together(drive([](int k) {
    return Nanoseconds(std::llround(30e6 * (static_cast<double>(k) / kPairs - 0.5)));
  }));
}

// That there is something to correct.
TEST_F(SkewedPairsTest, a_skew_that_is_not_told_does_harm) {
  EXPECT_GT(drive([](int) { return milliseconds(10); }, none).error_m, kUncorrectedError_m);
}

}  // namespace
}  // namespace egomod
