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

// A person of whom few points share a velocity, since the legs swing to and fro, and a box that
// after two seconds only the left camera sees; the egomotion is at times in doubt, and once fails.
class AllocationWithLimbs : public Filter {
 protected:
  static constexpr std::size_t kTrunk = 300, kLegs = kTrunk + 4, kBox = kLegs + 6;
  static constexpr int kHiddenFrom = 60, kEnd = 75;
  const Eigen::Vector3d walk_mps{1.0, 0.0, 0.1};

  AllocationWithLimbs() {
    rest_rig();
    world.add_background(kTrunk);
    world.add_box(kLegs - kTrunk, {-2.2, -0.3, 6.0}, {0.4, 0.4, 0.2}, walk_mps);
    world.add_box(kBox - kLegs, {-2.2, 0.3, 6.0}, {0.1, 0.3, 0.1}, walk_mps);
    world.add_box(30, {1.4, 0.1, 4.0}, {0.5, 0.5, 0.2}, {-0.2, 0.0, 0.0});
  }
  // Every second point of the legs goes ahead while the others fall behind.
  void swing(int pair) {
    const double swing_mps = 0.9 * std::sin(2.0 * M_PI * world.time_s(pair) / 1.2);
    for (std::size_t i = kLegs; i < kBox; ++i) {
      synthetic::Point& point = world.points[i];
      const Eigen::Vector3d now_mps =
          walk_mps + Eigen::Vector3d(i % 2 == 0 ? swing_mps : -swing_mps, 0.0, 0.0);
      point.at_start_m += world.time_s(pair) * (point.velocity_mps - now_mps);
      point.velocity_mps = now_mps;
    }
  }
  static void hide_box(TrackSet& tracks) {
    for (Track& track : tracks.tracks) {
      if (track.id <= kBox) continue;
      track.has_current = false;
      track.left_only = true;
    }
  }
  static EstimateStatus status(int pair) {
    if (pair == 40) return EstimateStatus::kFailed;
    return pair % 20 == 7 ? EstimateStatus::kAmbiguous : EstimateStatus::kValid;
  }
};

TEST_F(AllocationWithLimbs, AndPointsOfOneCameraTakesNoMemory) {
  run(0);
  int both = 0;
  int both_after = 0;
  for (int pair = 1; pair < kEnd; ++pair) {
    swing(pair);
    TrackSet tracks = world.tracks(pair);
    if (pair >= kHiddenFrom) hide_box(tracks);
    Egomotion motion = world.motion(tracks, pair);
    motion.status = status(pair);
    const long before = allocations();
    detector.detect(tracks, motion, objects);
    ASSERT_EQ(allocations(), before) << "pair " << pair;
    (pair < kHiddenFrom ? both : both_after) += moving() == 2 ? 1 : 0;
  }
  EXPECT_GT(both, 30) << "person and box were not exercised";
  EXPECT_GT(both_after, 10) << "what one camera sees was not exercised";
}

}  // namespace
}  // namespace egomod
