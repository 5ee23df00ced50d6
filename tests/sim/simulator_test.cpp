// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "world_file.hpp"

namespace egomod::sim {
namespace {

World thesis() { return read_world(find_world("thesis-moving", EGOMOD_WORLDS_DIR)); }

bool same(const Image& a, const Image& b) {
  for (int v = 0; v < a.height_px(); ++v) {
    if (std::memcmp(a.row(v), b.row(v), static_cast<std::size_t>(a.width_px())) != 0) return false;
  }
  return true;
}

TEST(Simulator, SameSeedSameBytes) {
  Image left;
  Image right;
  Image left_again;
  Image right_again;
  Simulator(thesis()).take_pair(5, left, right);
  Simulator(thesis()).take_pair(5, left_again, right_again);
  EXPECT_TRUE(same(left, left_again));
  EXPECT_TRUE(same(right, right_again));
  EXPECT_FALSE(same(left, right));
}

TEST(Simulator, TruthOfTheThesisTargetIsAnalytic) {
  Simulator simulator(thesis());
  Truth truth;
  simulator.take_truth(150, truth);
  ASSERT_EQ(truth.objects.size(), 1U);
  EXPECT_NEAR(truth.objects[0].truth.velocity_mps.norm(), 0.4 + 0.015 * 5.0, 1e-6);
  EXPECT_NEAR(truth.T_first_current.translation().z(), 2.0, 1e-6);
  EXPECT_GT(truth.objects[0].truth.visible_px, 400);
  EXPECT_EQ(truth.objects[0].truth.occluded_fraction, 0.0);
  // The rear face of box and base, towards the camera.
  EXPECT_NEAR(truth.objects[0].truth.box_centre_m.z(), 1.4 + 2.0 + 0.1875 - 2.0, 0.02);
}

}  // namespace
}  // namespace egomod::sim
