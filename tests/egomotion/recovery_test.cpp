// SPDX-License-Identifier: Apache-2.0
// Features and egomotion together, after images that show nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod {
namespace {

constexpr double kRate_hz = 30.0;
constexpr int kLastGoodPair = 5;
constexpr int kPairs = 24;
constexpr double kMaxError_m = 0.005;  // in dim light

void scale(Image& image, double light) {
  for (int v = 0; v < image.height_px(); ++v)
    for (int u = 0; u < image.width_px(); ++u)
      image.row(v)[u] = static_cast<std::uint8_t>(std::lround(light * image.row(v)[u]));
}

// The rig drives through a room; `light` is the share of it that falls on both images.
class RecoveryTest : public ::testing::Test {
 protected:
  void run(const std::function<double(int)>& light) {
    for (int k = 0; k < kPairs; ++k) {
      StereoPair pair;
      pair.sequence = static_cast<std::uint64_t>(k);
      const double t_s = k / kRate_hz;
      pair.exposure = pair.right_exposure = Nanoseconds(std::llround(t_s * 1e9));
      pair.calibration.camera = world_.camera();
      world_.render(t_s, pair.left, pair.right);
      scale(pair.left, light(k));
      scale(pair.right, light(k));
      tracker_.track(pair, tracks_);
      const Eigen::Isometry3d before = motion_.T_first_current;
      estimator_.estimate(tracks_, motion_);
      if (motion_.status == EstimateStatus::kValid) {
        last_valid_ = k;
        expect_true_motion(before, k);
      } else {
        last_invalid_ = k;
      }
    }
  }

  void expect_true_motion(const Eigen::Isometry3d& before, int k) const {
    if (motion_.reason != EstimateReason::kNone) return;
    const Eigen::Isometry3d truth =
        world_.T_first_current((k - 1) / kRate_hz).inverse() * world_.T_first_current(k / kRate_hz);
    const Eigen::Isometry3d found = before.inverse() * motion_.T_first_current;
    EXPECT_LT(se3_log(truth.inverse() * found).head<3>().norm(), kMaxError_m) << "pair " << k;
  }

  test_support::SyntheticWorld world_{
      test_support::static_room(), test_support::kinect_pair(320), {.noise_sigma = 1.0}};
  FeatureTracker tracker_{FeaturesConfig{}};
  EgomotionEstimator estimator_{EgomotionConfig{}};
  TrackSet tracks_;
  Egomotion motion_;
  int last_valid_ = -1;
  int last_invalid_ = -1;
};

TEST_F(RecoveryTest, a_covered_lens_costs_two_pairs_once_it_is_free) {
  constexpr int kFree = kLastGoodPair + 6;
  run([](int k) { return k > kLastGoodPair && k < kFree ? 0.0 : 1.0; });
  EXPECT_EQ(last_valid_, kPairs - 1);
  EXPECT_LE(last_invalid_, kFree + 1);
  EXPECT_EQ(motion_.reset_count, 1U);
}

TEST_F(RecoveryTest, light_that_comes_back_slowly_is_no_dead_end) {
  constexpr double kFirstLight = 1.0 / 512.0;
  run([](int k) {
    if (k <= kLastGoodPair) return 1.0;
    return std::min(1.0, kFirstLight * std::pow(2.0, k - kLastGoodPair - 1));
  });
  EXPECT_EQ(last_valid_, kPairs - 1);
  EXPECT_LE(last_invalid_, kLastGoodPair + 11);
  EXPECT_GE(motion_.reset_count, 1U);
}

}  // namespace
}  // namespace egomod
