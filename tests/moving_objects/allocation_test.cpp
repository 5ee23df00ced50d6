// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "counted_new.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
#include "filter_fixture.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

class Allocation : public ::testing::TestWithParam<MovingObjectsMethod> {};

TEST_P(Allocation, SteadyStateTakesNoMemory) {
  synthetic::World world;
  world.rate_hz = 30.0;
  world.pixel_sigma = 0.18;
  world.disparity_sigma_px = 0.25;
  world.add_background(900);
  world.add_box(60, {-0.5, 0.1, 4.0}, {0.5, 0.5, 0.4}, {0.8, 0.0, 0.0});
  std::vector<TrackSet> tracks;
  std::vector<Egomotion> motions;
  for (int pair = 0; pair < 60; ++pair) {
    tracks.push_back(world.tracks(pair));
    motions.push_back(world.motion(tracks.back(), pair));
  }
  MovingObjectDetector detector({.method = GetParam()});
  MovingObjects objects;
  detector.detect(tracks[0], motions[0], objects);
  bool found = false;
  const long before = allocations();
  for (std::size_t k = 1; k < tracks.size(); ++k) {
    detector.detect(tracks[k], motions[k], objects);
    found = found || !objects.objects.empty();
  }
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_TRUE(found) << "nothing was exercised";
}

INSTANTIATE_TEST_SUITE_P(Methods, Allocation,
                         ::testing::Values(MovingObjectsMethod::kThesis, MovingObjectsMethod::kLag,
                                           MovingObjectsMethod::kFilter));

// A person whose legs swing to and fro, and whom after two seconds only the left camera sees,
// before a rig whose egomotion is at times in doubt, and once fails.
class AllocationForAPerson : public Filter {
 protected:
  static constexpr std::size_t kTrunk = 600, kLegs = kTrunk + 8, kEnd = kLegs + 8;
  static constexpr int kHiddenFrom = 60;
  const Eigen::Vector3d walk_mps{0.6, 0.0, 0.1};

  AllocationForAPerson() {
    world.add_background(kTrunk);
    world.add_box(kLegs - kTrunk, {-1.4, -0.3, 5.0}, {0.4, 0.5, 0.2}, walk_mps);
    world.add_box(kEnd - kLegs, {-1.4, 0.3, 5.0}, {0.2, 0.5, 0.1}, walk_mps);
  }
  // Every second point of the legs goes ahead while the others fall behind.
  void swing(int pair) {
    const double swing_mps = 0.9 * std::sin(2.0 * M_PI * world.time_s(pair) / 1.2);
    for (std::size_t i = kLegs; i < kEnd; ++i) {
      synthetic::Point& point = world.points[i];
      const Eigen::Vector3d now_mps =
          walk_mps + Eigen::Vector3d(i % 2 == 0 ? swing_mps : -swing_mps, 0.0, 0.0);
      point.at_start_m += world.time_s(pair) * (point.velocity_mps - now_mps);
      point.velocity_mps = now_mps;
    }
  }
  static void hide(TrackSet& tracks) {
    for (Track& track : tracks.tracks) {
      if (track.id <= kTrunk) continue;
      track.has_current = false;
      track.left_only = true;
    }
  }
  static EstimateStatus status(int pair) {
    if (pair == 40) return EstimateStatus::kFailed;
    return pair % 20 == 7 ? EstimateStatus::kAmbiguous : EstimateStatus::kValid;
  }
};

TEST_F(AllocationForAPerson, SteadyStateTakesNoMemory) {
  run(0);
  int seen_by_both = 0;
  int seen_by_left = 0;
  for (int pair = 1; pair < kHiddenFrom + 15; ++pair) {
    swing(pair);
    TrackSet tracks = world.tracks(pair);
    if (pair >= kHiddenFrom) hide(tracks);
    Egomotion motion = world.motion(tracks, pair);
    motion.status = status(pair);
    const long before = allocations();
    detector.detect(tracks, motion, objects);
    ASSERT_EQ(allocations(), before) << "pair " << pair;
    (pair < kHiddenFrom ? seen_by_both : seen_by_left) += moving();
  }
  EXPECT_GT(seen_by_both, 30) << "no limbs were exercised";
  EXPECT_GT(seen_by_left, 5) << "no points of one camera were exercised";
}

}  // namespace
}  // namespace egomod
