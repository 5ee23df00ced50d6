// SPDX-License-Identifier: Apache-2.0
// What is still known of an object while it is hidden, or rests, and after.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "filter_fixture.hpp"

namespace egomod {
namespace {

// A box that crosses at 0.5 m/s before a rig at rest, known after a second.
class Crossing : public Filter {
 protected:
  Crossing() {
    rest_rig();
    world.add_background(kFirst);
    world.add_box(40, {-1.0, 0.1, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  }
  void SetUp() override {
    pass_until(30);
    ASSERT_EQ(moving(), 1);
    id = box().id;
    width_before_px = width_px();
  }
  void pass_until(int end) {
    for (; pair < end; ++pair) run(pair);
  }
  [[nodiscard]] const MovingObject& box() const { return objects.objects.front(); }
  [[nodiscard]] float width_px() const {
    return box().rectangle.u_max_px - box().rectangle.u_min_px;
  }
  void shift(const Eigen::Vector3d& by_m) {
    for (std::size_t i = kFirst; i < world.points.size(); ++i) world.points[i].at_start_m += by_m;
  }
  void hide() { shift({0.0, kOutOfView_m, 0.0}); }
  void show() { shift({0.0, -kOutOfView_m, 0.0}); }
  void expect_its_name() const {
    ASSERT_EQ(moving(), 1);
    EXPECT_EQ(moving_id(), id);
  }
  void expect_another_name() const {
    ASSERT_EQ(moving(), 1);
    EXPECT_NE(moving_id(), id);
  }

  static constexpr std::size_t kFirst = 300;  // of its points
  static constexpr double kOutOfView_m = 50.0;
  int pair = 0;
  std::int64_t id = 0;
  float width_before_px = 0.0F;
};

TEST_F(Crossing, OutlastsOneSecondOutOfSight) {
  hide();
  MovingObject before;
  for (; pair < 60; ++pair) {
    run(pair);
    ASSERT_EQ(objects.objects.size(), 1U);
    if (pair == 32) before = box();
    EXPECT_TRUE(pair < 32 || box().state == ObjectState::kCoasting);
    if (pair <= 32) continue;
    // The longer unseen, the less is known.
    EXPECT_GT(box().position_covariance_m2.trace(), before.position_covariance_m2.trace());
    EXPECT_GT(box().speed_sigma_mps, before.speed_sigma_mps);
    before = box();
  }
  show();
  pass_until(75);
  expect_its_name();
}

// Half of a known object's points lost at once are half of the object hidden or out of features.
TEST_F(Crossing, OutlineOutlastsItsPointsForAMoment) {
  for (std::size_t i = kFirst; i < world.points.size(); ++i) {
    Eigen::Vector3d& at_start_m = world.points[i].at_start_m;
    if (at_start_m.x() > -1.0) at_start_m.y() += kOutOfView_m;
  }
  run(pair++);
  ASSERT_EQ(moving(), 1);
  EXPECT_GT(width_px(), 0.8F * width_before_px);
  pass_until(60);
  ASSERT_EQ(moving(), 1);
  EXPECT_LT(width_px(), 0.65F * width_before_px) << "it is known to be gone after a second";
}

// Where it was thought to be while it was hidden is no outline.
TEST_F(Crossing, OutlineIsNoPrediction) {
  hide();
  turn(pair, kFirst, {0.25, 0.0, 0.0});
  pass_until(75);
  show();
  while (moving() == 0 && pair < 95) run(pair++);
  ASSERT_EQ(moving(), 1);
  EXPECT_LT(width_px(), 1.2F * width_before_px);
}

// Longer than objects coast: it is told no more, and has its name when it comes out.
TEST_F(Crossing, NameOutlastsThreeSecondsOutOfSight) {
  hide();
  pass_until(120);
  ASSERT_TRUE(objects.objects.empty());
  show();
  pass_until(135);
  expect_its_name();
  EXPECT_NEAR(box().age_s, world.time_s(134), 0.2) << "since it was first seen";
}

// It shows for a moment, too short to be told as moving.
TEST_F(Crossing, NameOutlastsAGlimpse) {
  hide();
  pass_until(110);
  show();
  while (objects.objects.empty() && pair < 120) run(pair++);
  ASSERT_EQ(count(ObjectState::kTentative), 1);
  EXPECT_EQ(box().id, id);
  hide();
  pass_until(135);
  ASSERT_TRUE(objects.objects.empty());
  show();
  pass_until(150);
  expect_its_name();
}

TEST_F(Crossing, NameOutlastsALongStop) {
  turn(pair, kFirst, {0.0, 0.0, 0.0});
  pass_until(200);
  ASSERT_TRUE(objects.objects.empty());
  turn(pair, kFirst, {0.0, 0.0, -0.5});
  pass_until(230);
  expect_its_name();
}

// Whoever turned while hidden may be somebody else, too: the name is kept, the proof asked anew.
TEST_F(Crossing, WhoTurnedWhileItCoastsHasItsNameAndProvesItself) {
  hide();
  turn(pair, kFirst, {0.35, 0.0, 0.45});
  pass_until(75);
  ASSERT_EQ(count(ObjectState::kCoasting), 1);
  show();
  bool was_tentative = false;
  for (; pair < 95; ++pair) {
    run(pair);
    ASSERT_EQ(objects.objects.size(), 1U) << "pair " << pair;
    EXPECT_EQ(box().id, id);
    was_tentative = was_tentative || box().state == ObjectState::kTentative;
  }
  EXPECT_TRUE(was_tentative);
  expect_its_name();
}

TEST_F(Crossing, WhoseCoastingEndsWithAGlimpseIsNotForgotten) {
  hide();
  turn(pair, kFirst, {0.35, 0.0, 0.45});
  pass_until(75);
  show();
  while (count(ObjectState::kTentative) == 0 && pair < 85) run(pair++);
  ASSERT_EQ(count(ObjectState::kTentative), 1);
  hide();
  pass_until(110);
  ASSERT_TRUE(objects.objects.empty());
  show();
  pass_until(125);
  expect_its_name();
}

// Its points are not where they were due, and say nothing of a velocity of theirs for a while.
TEST_F(Crossing, ThatSetsOffFastGoesOn) {
  world.pixel_sigma = 0.06;
  world.disparity_sigma_px = 0.08;
  shift({0.0, 0.0, -1.5});
  pass_until(60);
  expect_its_name();
  for (const double away_mps : {0.07, 0.14, 0.21, 0.28, 0.35, 0.42, 0.5, 0.57, 0.64, 0.71, 0.8}) {
    turn(pair, kFirst, {0.5, 0.0, away_mps});
    run(pair++);
    ASSERT_EQ(moving(), 1) << "pair " << pair;
  }
  expect_its_name();
}

TEST_F(Crossing, WhoComesOutElsewhereHasAnotherName) {
  hide();
  pass_until(120);
  show();
  shift({0.0, 0.0, 5.0});
  pass_until(145);
  expect_another_name();
}

TEST_F(Crossing, NameIsForgottenWithAReset) {
  turn(pair, kFirst, {0.0, 0.0, 0.0});
  pass_until(120);
  ASSERT_TRUE(objects.objects.empty());
  turn(pair, kFirst, {0.0, 0.0, -0.5});
  for (; pair < 150; ++pair) {
    const TrackSet tracks = world.tracks(pair);
    Egomotion motion = world.motion(tracks, pair);
    motion.reset_count = 1;
    detector.detect(tracks, motion, objects);
  }
  expect_another_name();
}

TEST_F(Crossing, StopIsSeenAndStartIsSeenAgain) {
  turn(pair, kFirst, {0.0, 0.0, 0.0});
  pass_until(45);
  ASSERT_EQ(count(ObjectState::kStopped), 1);
  EXPECT_EQ(box().speed_mps, 0.0);
  EXPECT_LT(box().motion_probability, 0.1);
  EXPECT_GE(box().points, 3);
  const Eigen::Vector3d place_m = box().position_m;
  pass_until(55);
  ASSERT_EQ(count(ObjectState::kStopped), 1);
  EXPECT_LT((box().position_m - place_m).norm(), 0.02) << "it stays there";
  turn(pair, kFirst, {0.5, 0.0, 0.0});
  pass_until(70);
  expect_its_name();
}

// Of something large another side is seen, before or behind what was.
TEST_F(Filter, AnotherSideOfWhatIsLargeIsTheSameObject) {
  rest_rig();
  world.add_background(300);
  world.add_box(40, {-1.2, 0.1, 4.0}, {1.6, 1.0, 0.1}, {0.5, 0.0, 0.0});
  world.add_box(40, {-1.2, 50.1, 5.0}, {0.2, 1.0, 0.1}, {0.5, 0.0, 0.0});
  for (int pair = 0; pair < 45; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const std::int64_t id = moving_id();
  for (std::size_t i = 300; i < 380; ++i) world.points[i].at_start_m.y() += i < 340 ? 50.0 : -50.0;
  for (int pair = 45; pair < 60; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_EQ(moving_id(), id);
}

TEST_F(Crossing, WhoFollowsFarBehindIsSomebodyElse) {
  hide();
  world.add_box(40, {-1.0, 0.1 + kOutOfView_m, 7.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  pass_until(70);
  ASSERT_EQ(count(ObjectState::kCoasting), 1);
  for (std::size_t i = kFirst + 40; i < world.points.size(); ++i)
    world.points[i].at_start_m.y() -= kOutOfView_m;
  pass_until(85);
  expect_another_name();
  EXPECT_EQ(count(ObjectState::kCoasting), 1);
}

// It is still there, at rest, and large.
TEST_F(Filter, WhoPassesWhatHasStoppedIsSomebodyElse) {
  rest_rig();
  world.add_background(300);
  world.add_box(80, {-1.2, 0.1, 6.0}, {2.0, 1.0, 0.1}, {0.6, 0.0, 0.0});
  world.add_box(30, {1.4, 50.1, 6.0}, {0.4, 0.6, 0.1}, {0.6, 0.0, -0.2});
  for (int pair = 0; pair < 45; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  const std::int64_t id = moving_id();
  for (std::size_t i = 300; i < 380; ++i) {
    world.points[i].at_start_m += world.time_s(45) * world.points[i].velocity_mps;
    world.points[i].velocity_mps.setZero();
  }
  for (int pair = 45; pair < 75; ++pair) run(pair);
  ASSERT_EQ(count(ObjectState::kStopped), 1);
  for (std::size_t i = 380; i < 410; ++i)
    world.points[i].at_start_m -= Eigen::Vector3d(world.time_s(75) * 0.6, 50.0, 0.0);
  for (int pair = 75; pair < 90; ++pair) run(pair);
  ASSERT_EQ(moving(), 1);
  EXPECT_NE(moving_id(), id);
  EXPECT_EQ(count(ObjectState::kStopped), 1);
}

// Who comes out beside somebody takes no name that the other has again.
TEST_F(Crossing, OneOfTwoThatComeOutHasItsName) {
  hide();
  world.add_box(30, {0.0, 0.1 + kOutOfView_m, 5.0}, {0.5, 0.5, 0.4}, {0.5, 0.0, 0.0});
  pass_until(66);
  ASSERT_EQ(count(ObjectState::kCoasting), 1);
  show();
  pass_until(80);
  ASSERT_EQ(moving(), 2);
  EXPECT_EQ(std::count_if(objects.objects.begin(), objects.objects.end(),
                          [this](const auto& object) { return object.id == id; }),
            1);
}

}  // namespace
}  // namespace egomod
