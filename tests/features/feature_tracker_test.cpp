// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/feature_tracker.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <new>
#include <random>
#include <vector>

#include "egomod/core/geometry.hpp"
#include "scenes.hpp"
#include "synthetic_world.hpp"
#include "test_images.hpp"

namespace {
std::atomic<long> g_allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++g_allocations;
  void* p = alignment > alignof(std::max_align_t)
                ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                : std::malloc(size);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace

void* operator new(std::size_t size) { return counted(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace egomod {
namespace {

using test_support::SyntheticWorld;

constexpr int kWidth = 320;
constexpr double kRate_hz = 30.0;
constexpr int kPairs = 24;
constexpr double kNoise = 1.5;  // grey levels
constexpr double kMaxMedianResidual_px = 0.2;
constexpr double kMaxMedianDisparityError_px = 0.15;
constexpr double kMedianChi2Of3 = 2.366;
constexpr double kMaxSigmaFactor = 2.1;

StereoPair pair_at(const SyntheticWorld& world, double t_s, std::uint64_t sequence) {
  StereoPair pair;
  pair.sequence = sequence;
  pair.exposure = Nanoseconds(std::llround(t_s * 1e9));
  pair.right_exposure = pair.exposure;
  pair.calibration.camera = world.camera();
  world.render(t_s, pair.left, pair.right);
  return pair;
}

StereoPair painted_pair(const Image& left, const Image& right) {
  StereoPair pair;
  copy_image(left.view(), pair.left);
  copy_image(right.view(), pair.right);
  return pair;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

bool finite(const StereoObservation& o) {
  const bool values = std::isfinite(o.u_px + o.v_px + o.disparity_px);
  return values && std::all_of(o.covariance_px2.begin(), o.covariance_px2.end(),
                               [](float c) { return std::isfinite(c); });
}

// What a track's two observations say against the true motion of the rig.
struct Residual {
  Eigen::Vector3d uvd_px;
  double chi2;
};
Residual residual(const StereoCamera& camera, const Eigen::Isometry3d& T_current_previous,
                  const StereoObservation& previous, const StereoObservation& current) {
  const Eigen::Vector3d P = triangulate(camera, uvd(previous));
  const Eigen::Vector3d Q = T_current_previous * P;
  const Eigen::Vector3d r = uvd(current) - project(camera, Q);
  const Eigen::Matrix3d J = project_jacobian(camera, Q) * T_current_previous.linear() *
                            triangulate_jacobian(camera, uvd(previous));
  const Eigen::Matrix3d S = covariance(current) + J * covariance(previous) * J.transpose();
  return {r, r.dot(S.inverse() * r)};
}

// Pairs of a furnished room seen by a rig in motion, rendered once for all tests.
class FeatureTrackerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_unique<SyntheticWorld>(
        test_support::static_room(), test_support::kinect_pair(kWidth),
        test_support::RenderOptions{.noise_sigma = kNoise, .seed = 1});
    for (int i = 0; i < kPairs; ++i) {
      pairs_.push_back(
          std::make_unique<StereoPair>(pair_at(*world_, i / kRate_hz, std::uint64_t(i))));
    }
  }
  static void TearDownTestSuite() {
    pairs_.clear();
    world_.reset();
  }

  static const StereoPair& pair(int i) { return *pairs_[static_cast<std::size_t>(i)]; }
  static Eigen::Isometry3d T_current_previous(double current_s, double previous_s) {
    return world_->T_first_current(current_s).inverse() * world_->T_first_current(previous_s);
  }
  const TrackSet& track(const StereoPair& pair) {
    tracker_.track(pair, tracks_);
    return tracks_;
  }
  [[nodiscard]] std::vector<Residual> residuals(double current_s, double previous_s) const {
    std::vector<Residual> all;
    for (const Track& t : tracks_.tracks) {
      if (!t.has_current || !t.has_previous) continue;
      all.push_back(residual(tracks_.camera, T_current_previous(current_s, previous_s), t.previous,
                             t.current));
    }
    return all;
  }

  static inline std::unique_ptr<SyntheticWorld> world_;
  static inline std::vector<std::unique_ptr<StereoPair>> pairs_;
  FeatureTracker tracker_{FeaturesConfig{.max_tracks = 500}};
  TrackSet tracks_;
};

TEST(MaxTracks, AreFewerWhereKernelsAreNarrowUnlessTheyAreGiven) {
  EXPECT_LT(usual_max_tracks(InstructionSet::kBaseline),
            usual_max_tracks(InstructionSet::kX86_64V3));
  EXPECT_EQ(usual_max_tracks(InstructionSet::kX86_64V3),
            usual_max_tracks(InstructionSet::kX86_64V4));
  EXPECT_EQ(max_tracks({}), usual_max_tracks(instruction_set()));
  EXPECT_EQ(max_tracks({.max_tracks = 77}), 77);
}

TEST_F(FeatureTrackerTest, FirstPairSeedsTracksWithStereoAndNoPast) {
  const TrackSet& first = track(pair(0));
  EXPECT_EQ(first.status, TrackStatus::kFirst);
  EXPECT_GT(first.tracks.size(), 150U);
  EXPECT_EQ(first.previous_exposure, first.exposure);
  for (const Track& t : first.tracks) {
    EXPECT_EQ(t.age, 0U);
    EXPECT_TRUE(t.has_current);
    EXPECT_FALSE(t.has_previous);
  }
}

TEST_F(FeatureTrackerTest, DisparitiesAgreeWithTrueDepth) {
  const std::vector<float> depth_m = world_->pixels(0.0).depth_m;
  std::vector<double> errors;
  for (const Track& t : track(pair(0)).tracks) {
    const auto u = static_cast<std::size_t>(std::lround(t.current.u_px));
    const auto v = static_cast<std::size_t>(std::lround(t.current.v_px));
    const double z = static_cast<double>(depth_m[v * kWidth + u]);
    const double disparity_px = world_->camera().fx_px * world_->camera().baseline_m / z;
    errors.push_back(std::abs(t.current.disparity_px - disparity_px));
  }
  EXPECT_LT(median(errors), kMaxMedianDisparityError_px);
}

TEST_F(FeatureTrackerTest, StaticPointsAgreeWithTheTrueMotion) {
  std::vector<double> image_px;
  std::vector<double> disparity_px;
  for (int i = 0; i < kPairs; ++i) {
    track(pair(i));
    for (const Residual& r : residuals(i / kRate_hz, (i - 1) / kRate_hz)) {
      image_px.push_back(r.uvd_px.head<2>().norm());
      disparity_px.push_back(std::abs(r.uvd_px.z()));
    }
  }
  EXPECT_LT(median(image_px), kMaxMedianResidual_px);
  EXPECT_LT(median(disparity_px), kMaxMedianResidual_px);
}

// Errors of a track are correlated from pair to pair, since all are measured against one template:
// the covariance has to hold over its life.
TEST_F(FeatureTrackerTest, CovariancesHoldOverALife) {
  std::map<std::uint64_t, StereoObservation> seeds;
  for (int i = 0; i < kPairs; ++i) {
    track(pair(i));
    if (i > 0) continue;
    for (const Track& t : tracks_.tracks) seeds[t.id] = t.current;
  }
  std::vector<double> chi2;
  const double now_s = (kPairs - 1) / kRate_hz;
  for (const Track& t : tracks_.tracks) {
    if (!t.has_current || !seeds.contains(t.id)) continue;
    const Eigen::Isometry3d T = T_current_previous(now_s, 0.0);
    chi2.push_back(residual(tracks_.camera, T, seeds[t.id], t.current).chi2);
  }
  EXPECT_GT(chi2.size(), 50U);
  EXPECT_GT(median(chi2), kMedianChi2Of3 / (kMaxSigmaFactor * kMaxSigmaFactor));
  EXPECT_LT(median(chi2), kMedianChi2Of3 * (kMaxSigmaFactor * kMaxSigmaFactor));
}

TEST_F(FeatureTrackerTest, TracksLive) {
  for (int i = 0; i < kPairs; ++i) track(pair(i));
  const auto old = std::count_if(tracks_.tracks.begin(), tracks_.tracks.end(),
                                 [](const Track& t) { return t.age >= kPairs / 2; });
  EXPECT_EQ(tracks_.status, TrackStatus::kOk);
  EXPECT_GT(static_cast<double>(old), 0.4 * static_cast<double>(tracks_.tracks.size()));
}

TEST_F(FeatureTrackerTest, PreviousIsWhatTheLastPairSaid) {
  std::map<std::uint64_t, Track> last;
  std::uint64_t highest = 0;
  for (int i = 0; i < 12; ++i) {
    std::uint64_t id = 0;
    std::uint64_t highest_before = highest;
    for (const Track& t : track(pair(i)).tracks) {
      EXPECT_GT(t.id, id);
      id = t.id;
      highest = std::max(highest, id);
      EXPECT_TRUE(finite(t.current) && finite(t.previous));
      const auto before = last.find(t.id);
      if (t.age == 0) {
        EXPECT_GT(t.id, highest_before) << "an identity was used again";
      } else {
        ASSERT_NE(before, last.end());
        EXPECT_EQ(t.age, before->second.age + 1);
        EXPECT_EQ(t.has_previous, before->second.has_current);
        EXPECT_EQ(t.previous.u_px, before->second.current.u_px);
        EXPECT_EQ(t.previous.disparity_px, before->second.current.disparity_px);
      }
    }
    last.clear();
    for (const Track& t : tracks_.tracks) last[t.id] = t;
  }
}

TEST_F(FeatureTrackerTest, SkippedAndRejectedPairsLeaveTheTracksWaiting) {
  track(pair(0));
  track(pair(1));
  const std::vector<Track> before = tracks_.tracks;
  for (const PairStatus status : {PairStatus::kSkipped, PairStatus::kRejected}) {
    StereoPair hole;
    hole.status = status;
    EXPECT_EQ(track(hole).status, TrackStatus::kNotRun);
    EXPECT_TRUE(tracks_.tracks.empty());
  }
  track(pair(3));
  EXPECT_EQ(tracks_.status, TrackStatus::kOk);
  EXPECT_EQ(tracks_.previous_exposure, pair(1).exposure);
  const auto shared = std::count_if(tracks_.tracks.begin(), tracks_.tracks.end(),
                                    [&](const Track& t) { return t.id <= before.back().id; });
  EXPECT_GT(static_cast<double>(shared), 0.8 * static_cast<double>(before.size()));
}

TEST_F(FeatureTrackerTest, LongGapsAreBridged) {
  for (const double gap_s : {0.2, 1.0}) {
    FeatureTracker tracker({});
    tracker.track(pair(0), tracks_);
    tracker.track(pair_at(*world_, gap_s, 1), tracks_);
    const std::vector<Residual> all = residuals(gap_s, 0.0);
    const auto right = std::count_if(all.begin(), all.end(),
                                     [](const Residual& r) { return r.uvd_px.norm() < 3.0; });
    EXPECT_GT(all.size(), 60U) << gap_s << " s";
    EXPECT_GT(static_cast<double>(right), 0.85 * static_cast<double>(all.size())) << gap_s << " s";
  }
}

TEST_F(FeatureTrackerTest, ACutOrANewSizeSeedsAgain) {
  track(pair(0));
  track(pair(1));
  StereoPair cut = pair_at(*world_, 2.0 / kRate_hz, 2);
  cut.discontinuity = true;
  EXPECT_EQ(track(cut).status, TrackStatus::kReseeded);
  const SyntheticWorld larger(test_support::static_room(), test_support::kinect_pair(400));
  EXPECT_EQ(track(pair_at(larger, 0.1, 3)).status, TrackStatus::kReseeded);
  for (const Track& t : tracks_.tracks) EXPECT_EQ(t.age, 0U);
  EXPECT_EQ(track(pair_at(larger, 0.12, 4)).status, TrackStatus::kOk);
}

TEST_F(FeatureTrackerTest, ANewCalibrationDoesNotEndTheTracks) {
  track(pair(0));
  StereoPair changed = pair_at(*world_, 1.0 / kRate_hz, 1);
  changed.calibration.camera.fx_px *= 1.1;
  EXPECT_EQ(track(changed).status, TrackStatus::kOk);
  EXPECT_EQ(tracks_.camera, changed.calibration.camera);
}

TEST_F(FeatureTrackerTest, AnotherRectificationSeedsAgain) {
  StereoPair first = pair_at(*world_, 0.0, 0);
  first.calibration.images_are_raw = true;
  track(first);
  StereoPair turned = pair_at(*world_, 1.0 / kRate_hz, 1);
  turned.calibration = first.calibration;
  turned.calibration.right.R_rectified_raw =
      Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(track(turned).status, TrackStatus::kReseeded);
  EXPECT_TRUE(tracks_.discontinuity);
}

TEST_F(FeatureTrackerTest, UnequalOrEmptyImagesAreNotTracked) {
  track(pair(0));
  StereoPair broken = pair_at(*world_, 0.0, 1);
  broken.right.resize(kWidth / 2, 100);
  EXPECT_EQ(track(broken).status, TrackStatus::kNotRun);
  EXPECT_EQ(track(StereoPair{}).status, TrackStatus::kNotRun);
  EXPECT_EQ(track(pair(1)).status, TrackStatus::kOk);
}

TEST_F(FeatureTrackerTest, ImagesWithoutTextureGiveFewTracks) {
  std::vector<StereoPair> poor;
  for (const double grey : {0.0, 255.0, 120.0}) {
    const Image flat = testing::flat_image(kWidth, 240, grey, 0.0);
    poor.push_back(painted_pair(flat, flat));
  }
  poor.push_back(painted_pair(testing::flat_image(kWidth, 240, 120.0, 20.0, 1),
                              testing::flat_image(kWidth, 240, 120.0, 20.0, 2)));
  for (const StereoPair& p : poor) EXPECT_EQ(track(p).status, TrackStatus::kFew);
  track(pair(0));
  for (const StereoPair& p : poor) EXPECT_EQ(track(p).status, TrackStatus::kFew);
}

TEST_F(FeatureTrackerTest, SameInputGivesTheSameTracks) {
  FeatureTracker other(FeaturesConfig{.max_tracks = 500});
  TrackSet again;
  for (int i = 0; i < 6; ++i) {
    track(pair(i));
    other.track(pair(i), again);
  }
  ASSERT_EQ(tracks_.tracks.size(), again.tracks.size());
  for (std::size_t i = 0; i < again.tracks.size(); ++i) {
    EXPECT_EQ(tracks_.tracks[i].id, again.tracks[i].id);
    EXPECT_EQ(uvd(tracks_.tracks[i].current), uvd(again.tracks[i].current));
    EXPECT_EQ(tracks_.tracks[i].current.covariance_px2, again.tracks[i].current.covariance_px2);
  }
}

TEST_F(FeatureTrackerTest, NothingIsAllocatedOnceRunning) {
  for (int i = 0; i < 20; ++i) track(pair(i));
  const long before = g_allocations;
  for (int i = 20; i < kPairs; ++i) track(pair(i));
  EXPECT_EQ(g_allocations - before, 0);
}

// As where clocks run free: pairs with a skew come between those without.
TEST_F(FeatureTrackerTest, ASkewAllocatesNothingEither) {
  std::vector<StereoPair> skewed;
  for (int i = 20; i < kPairs; ++i) {
    skewed.push_back(pair_at(*world_, i / kRate_hz, std::uint64_t(i)));
    skewed.back().right_exposure += std::chrono::milliseconds(10);
  }
  for (int i = 0; i < 20; ++i) track(pair(i));
  const long before = g_allocations;
  for (const StereoPair& pair : skewed) track(pair);
  EXPECT_EQ(g_allocations - before, 0);
}

}  // namespace
}  // namespace egomod
