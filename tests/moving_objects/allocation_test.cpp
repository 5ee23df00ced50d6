// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "counted_new.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
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

}  // namespace
}  // namespace egomod
