// SPDX-License-Identifier: Apache-2.0
#include "detection.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace egomod::eval {
namespace {

constexpr double kExact = 1e-9;

// 10 Hz, 31 frames: one object 5 m away moves sideways at 1 m/s in every frame.
Truth one_mover() {
  Truth truth;
  truth.focal_px = 500.0;
  truth.baseline_m = 0.4;
  truth.objects.emplace();
  for (int i = 0; i < 31; ++i) {
    truth.times_s.push_back(0.1 * i);
    TruthObject object;
    object.id = "1";
    object.time_s = 0.1 * i;
    object.surface_m = {0.0, 0.0, 5.0};
    object.centre_m = {0.0, 0.0, 5.2};
    object.velocity_mps = {1.0, 0.0, 0.0};
    object.rectangle = {100.0, 100.0, 199.0, 199.0};
    object.visible_px = 10000;
    object.moving = true;
    (*truth.objects)[i].push_back(object);
  }
  return truth;
}

Detection found(const char* track, double u_px) {
  Detection detection;
  detection.track = track;
  detection.time_s = std::nan("");
  detection.position_m = {0.0, 0.3, 5.4};
  detection.velocity_mps = {1.0, 0.0, 0.2};
  detection.rectangle = {u_px, 100.0, u_px + 99.0, 199.0};
  return detection;
}

ByFrame<Detection> from_frame(int first) {
  ByFrame<Detection> detections;
  for (int i = first; i < 31; ++i) detections[i].push_back(found("7", 100.0));
  return detections;
}

TEST(Detection, RectanglesOverlapWithTheirEdges) {
  EXPECT_NEAR(overlap({0, 0, 9, 9}, {0, 0, 9, 9}), 1.0, kExact);
  EXPECT_NEAR(overlap({0, 0, 9, 9}, {5, 0, 14, 9}), 50.0 / 150.0, kExact);
  EXPECT_NEAR(overlap({0, 0, 9, 9}, {10, 0, 19, 9}), 0.0, kExact);
}

// Qualifies from frame 1 on, is due from frame 11 on: 20 frames, found from frame 16 on: 15.
TEST(Detection, CountsAreWorkedOutByHand) {
  const DetectionFigures figures = score_detection(one_mover(), from_frame(16), {});
  EXPECT_EQ(figures.frames, 30);
  EXPECT_EQ(figures.tp, 15);
  EXPECT_EQ(figures.fn, 5);
  EXPECT_EQ(figures.fp, 0);
  EXPECT_NEAR(*figures.recall, 0.75, kExact);
  EXPECT_NEAR(*figures.f1, 30.0 / 35.0, kExact);
  EXPECT_NEAR(figures.delay_s->mean, 1.5, kExact);
  EXPECT_NEAR(figures.position_m->median, 0.5, kExact);
  EXPECT_NEAR(figures.position_percent->median, 10.0, kExact);
  EXPECT_NEAR(figures.position_to_centre_m->median, std::hypot(0.3, 0.2), kExact);
  EXPECT_FALSE(figures.time_mismatch_s);  // none of them has a time
  EXPECT_NEAR(figures.velocity_mps->rmse, 0.2, kExact);
  EXPECT_NEAR(figures.speed_mps->median, std::sqrt(1.04) - 1.0, kExact);
  EXPECT_NEAR(figures.velocity_bias_mps->z(), 0.2, kExact);
}

TEST(Detection, ASecondEstimateOfOneObjectIsFalse) {
  ByFrame<Detection> detections = from_frame(1);
  detections[20].push_back(found("8", 110.0));
  const DetectionFigures figures = score_detection(one_mover(), detections, {});
  EXPECT_EQ(figures.tp, 20);
  EXPECT_EQ(figures.fp, 1);
  EXPECT_EQ(figures.duplicates, 1);
  EXPECT_EQ(figures.switches, 0);
}

TEST(Detection, AnEstimateOnNothingIsFalse) {
  ByFrame<Detection> detections;
  detections[3].push_back(found("8", 400.0));
  detections[60].push_back(found("8", 400.0));
  const DetectionFigures figures = score_detection(one_mover(), detections, {});
  EXPECT_EQ(figures.fp, 1);
  EXPECT_EQ(figures.rows_outside, 1);
  EXPECT_NEAR(figures.false_per_minute, 60.0 / 3.0, kExact);
  EXPECT_EQ(figures.never_detected, 1);
}

TEST(Detection, AnEstimateOnAnObjectAtRestIsFalseAndOneOnASmallMoverIsNeither) {
  Truth truth = one_mover();
  for (auto& [frame, objects] : *truth.objects) objects.front().moving = false;
  EXPECT_EQ(score_detection(truth, from_frame(1), {}).fp_on_still, 30);
  truth = one_mover();
  for (auto& [frame, objects] : *truth.objects) objects.front().visible_px = 399;
  const DetectionFigures small = score_detection(truth, from_frame(1), {});
  EXPECT_EQ(small.fp, 0);
  EXPECT_EQ(small.ignored, 30);
}

TEST(Detection, CountsIdentitySwitches) {
  ByFrame<Detection> detections = from_frame(1);
  for (int i = 20; i < 30; ++i) detections[i].front() = found("9", 100.0);
  detections[30].front() = found("7", 100.0);
  const DetectionFigures figures = score_detection(one_mover(), detections, {});
  EXPECT_EQ(figures.switches, 2);
  EXPECT_EQ(figures.objects.at("1").tracks, 2);
}

TEST(Detection, AtALowerRateOnlyEveryFrameOfItCounts) {
  const DetectionFigures figures = score_detection(one_mover(), from_frame(0), {.every = 5});
  EXPECT_EQ(figures.frames, 6);  // 5, 10, ... 30
  EXPECT_EQ(figures.tp, 4);      // due from 1.5 s on
}

// 10 points: sigma_v = sigma * sqrt(12 / 990) * 10; lateral sigma = 5 * 0.25 / sqrt(2) / 500.
TEST(Detection, TheLeastSpeedIsThatOfTheDefinition) {
  const double sigma_m = 5.0 * 0.25 / std::sqrt(2.0) / 500.0;
  const double expected = std::hypot(0.05, 2.5 * sigma_m * std::sqrt(12.0 / 990.0) * 10.0);
  EXPECT_NEAR(v90_mps(one_mover().objects->at(0).front(), 10.0, 500.0, 0.4), expected, kExact);
}

// A run that took pairs 0, 5, 10, ... is scored as one of a sequence of those.
TEST(Detection, OfChosenFramesIsThatOfTheirRate) {
  std::vector<int> taken;
  for (int frame = 0; frame < 31; frame += 5) taken.push_back(frame);
  const DetectionFigures chosen = score_detection(one_mover(), from_frame(0), {.only = taken});
  const DetectionFigures every = score_detection(one_mover(), from_frame(0), {.every = 5});
  EXPECT_EQ(chosen.frames, 6);
  EXPECT_EQ(chosen.tp, every.tp);
  EXPECT_EQ(chosen.fn, 0);
  EXPECT_NEAR(chosen.duration_s, every.duration_s, kExact);
}

}  // namespace
}  // namespace egomod::eval
