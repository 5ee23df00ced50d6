// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "small_world.hpp"
#include "world_file.hpp"

namespace egomod::sim {
namespace {

constexpr double kExact = 1e-6;

bool same(const Image& a, const Image& b) {
  for (int v = 0; v < a.height_px(); ++v) {
    if (std::memcmp(a.row(v), b.row(v), static_cast<std::size_t>(a.width_px())) != 0) return false;
  }
  return true;
}

TEST(Simulator, LooksInAnyOrder) {
  Simulator simulator(test::world_of(test::unreal_room()));
  Image left;
  Image right;
  Image again;
  simulator.take_pair(5, left, right);
  simulator.take_image(Eye::kRight, 2, again);
  EXPECT_FALSE(same(right, again));
  simulator.take_image(Eye::kRight, 5, again);
  EXPECT_TRUE(same(right, again));
  simulator.take_image(Eye::kLeft, 5, again);
  EXPECT_TRUE(same(left, again));
}

TEST(Simulator, TruthOfTheThesisTargetIsAnalytic) {
  World thesis = read_world(find_world("thesis-moving", EGOMOD_WORLDS_DIR));
  thesis.posters.clear();  // to be painted quickly
  thesis.shell.height_m = 1.2;
  Simulator simulator(thesis);
  Truth truth;
  simulator.take_truth(150, truth);
  ASSERT_EQ(truth.objects.size(), 1U);
  EXPECT_NEAR(truth.objects[0].truth.velocity_mps.norm(), 0.4 + 0.015 * 5.0, kExact);
  EXPECT_NEAR(truth.T_first_current.translation().z(), 2.0, kExact);
  EXPECT_GT(truth.objects[0].truth.visible_px, 400);
  EXPECT_EQ(truth.objects[0].truth.occluded_fraction, 0.0);
  // The rear face of box and base, towards the camera.
  EXPECT_NEAR(truth.objects[0].truth.box_centre_m.z(), 1.4 + 2.0 + 0.1875 - 2.0, 0.02);
}

TEST(Simulator, TruthOfTheRigIsItsMotion) {
  Simulator simulator(test::world_of(test::small_room()));
  Truth truth;
  simulator.take_truth(12, truth);
  const double turned = 10.0 * M_PI / 180.0 * 0.4;
  EXPECT_NEAR((truth.velocity_mps - Eigen::Vector3d(0, 0, 0.3)).norm(), 0.0, kExact);
  EXPECT_NEAR(truth.angular_velocity_radps.y(), 10.0 * M_PI / 180.0, kExact);
  EXPECT_NEAR(truth.T_first_current.linear()(0, 2), std::sin(turned), kExact);
}

TEST(Simulator, ABoxThatTurnsOnTheSpotMovesAtItsSurfaceOnly) {
  Simulator simulator(test::world_of(test::small_room()));
  Truth truth;
  simulator.take_truth(0, truth);
  const test_support::ObjectTruth& box = truth.objects.at(1).truth;
  const double spin = 60.0 * M_PI / 180.0;
  EXPECT_TRUE(box.moving);
  EXPECT_NEAR(box.angular_velocity_radps.y(), spin, kExact);
  EXPECT_NEAR(
      box.velocity_mps.norm(),
      spin *
          (box.surface_centroid_m - box.box_centre_m).cwiseProduct(Eigen::Vector3d(1, 0, 1)).norm(),
      kExact);
  EXPECT_NEAR((truth.objects[1].extent_m - Eigen::Vector3d(0.4, 0.5, 0.2)).norm(), 0.0, kExact);
}

}  // namespace
}  // namespace egomod::sim
