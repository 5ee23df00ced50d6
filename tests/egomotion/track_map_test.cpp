// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/track_map.hpp"

#include <gtest/gtest.h>

#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

class TrackMapTest : public ::testing::Test {
 protected:
  // One pair of a rig at rest.
  void see(bool is_doubted, bool is_held) {
    const TrackSet& tracks = world_.step(Eigen::Isometry3d::Identity(), 1.0 / 30.0);
    map_.align(tracks.tracks, 1.0 / 30.0);
    map_.update(tracks.camera, tracks.tracks, Eigen::Isometry3d::Identity(), Matrix6d::Zero(), 1.0,
                is_doubted, true, is_held);
  }

  synthetic::World world_{1, 100};
  TrackMap map_{TrackMapConfig{}};
};

TEST_F(TrackMapTest, HeldPointsStayWhereTheyWereFirstSeen) {
  see(false, false);
  const std::vector<MapPoint> first(map_.points().begin(), map_.points().end());
  for (int k = 0; k < 5; ++k) see(false, true);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(map_.points()[i].P_first_m, first[i].P_first_m);
    EXPECT_EQ(map_.points()[i].held, 5);
  }
  see(false, false);
  EXPECT_NE(map_.points()[0].P_first_m, first[0].P_first_m);
}

// The rival finder takes logarithms of sums of it.
TEST_F(TrackMapTest, WhatIsHeldAndDoubtedIsNotKnownLessThanNotAtAll) {
  see(true, false);
  for (int k = 0; k < 8; ++k) see(true, true);
  for (const MapPoint& point : map_.points()) EXPECT_GE(known_static(point), 0.0);
}

}  // namespace
}  // namespace egomod
