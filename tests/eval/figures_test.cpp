// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "consistency.hpp"
#include "figure_tables.hpp"
#include "kitti_writer.hpp"
#include "noise.hpp"
#include "points.hpp"
#include "statistics.hpp"

namespace egomod::eval {
namespace {

constexpr double kExact = 1e-9;

TEST(Statistics, AreThoseOfAHandfulOfNumbers) {
  const auto s = summarise({4.0, 1.0, std::nan(""), 3.0, 2.0});
  EXPECT_EQ(s->count, 4U);
  EXPECT_NEAR(s->median, 2.5, kExact);
  EXPECT_NEAR(s->mean, 2.5, kExact);
  EXPECT_NEAR(s->p90, 3.7, kExact);
  EXPECT_NEAR(s->rmse, std::sqrt(7.5), kExact);
  EXPECT_FALSE(summarise({std::nan("")}).has_value());
}

Truth standing(int frames) {
  Truth truth;
  for (int i = 0; i < frames; ++i) {
    truth.times_s.push_back(0.5 * i);
    truth.poses.push_back({i, Eigen::Isometry3d::Identity()});
  }
  return truth;
}

// Each pose is 2 sigma off along one axis: NEES 4 of 6 degrees of freedom.
TEST(Consistency, OfAPoseTwoSigmaOffIsFourOverSix) {
  std::vector<PoseEvidence> poses(5);
  for (int i = 0; i < 5; ++i) {
    PoseEvidence& pose = poses[static_cast<std::size_t>(i)];
    pose.frame = i;
    pose.estimated = true;
    pose.covariance = 1e-4 * i * Eigen::Matrix<double, 6, 6>::Identity();
    pose.T_first_camera.translation().x() = 2.0 * std::sqrt(1e-4 * i);
  }
  const ConsistencyFigures figures = score_consistency(standing(5), poses, {});
  EXPECT_EQ(figures.pose->count, 4U);
  EXPECT_NEAR(figures.pose->mean_per_dof, 4.0 / 6.0, 1e-6);
  EXPECT_NEAR(figures.pose->within_95, 1.0, kExact);
  EXPECT_EQ(figures.second_by_pose->count, 3U);  // from 0, 1 and 2, two pairs each
  EXPECT_FALSE(figures.pair.has_value());
}

TEST(Consistency, OfMotionsComposesThePairs) {
  std::vector<PoseEvidence> poses(3);
  for (int i = 0; i < 3; ++i) {
    PoseEvidence& pose = poses[static_cast<std::size_t>(i)];
    pose.frame = i;
    pose.estimated = true;
    pose.motion_covariance = 0.5 * Eigen::Matrix<double, 6, 6>::Identity();
    pose.T_first_camera.translation().y() = 0.5 * i;
  }
  const ConsistencyFigures figures = score_consistency(standing(3), poses, {});
  EXPECT_NEAR(figures.pair->mean_per_dof, 0.25 / 0.5 / 6.0, 1e-9);
  EXPECT_NEAR(figures.second_by_pairs->mean_per_dof, 1.0 / 1.0 / 6.0, 1e-9);
}

Truth scene_of_points() {
  Truth truth;
  truth.times_s = {0.0, 1.0};
  TruthObject mover;
  mover.surface_m = {0.0, 0.0, 5.0};
  mover.centre_m = {0.0, 0.0, 5.2};
  mover.rectangle = {100, 100, 200, 200};
  mover.visible_px = 5000;
  mover.moving = true;
  truth.objects.emplace();
  (*truth.objects)[1].push_back(mover);
  return truth;
}

PointEvidence point(double u_px, double depth_m, double speed_mps, bool moving) {
  return {.frame = 1,
          .u_px = u_px,
          .v_px = 150.0,
          .depth_m = depth_m,
          .speed_mps = speed_mps,
          .moving = moving};
}

// Speeds 1.0 and 0.3 move, 0.4 and 0.1 do not: three of the four pairs are in the right order.
TEST(Points, AreCountedByRectangleAndDepth) {
  const PointFigures figures = score_points(
      scene_of_points(),
      {point(150, 5.1, 1.0, true), point(150, 5.0, 0.3, false), point(150, 9.0, 2.0, true),
       point(50, 5.0, 0.4, true), point(300, 2, 0.1, false)},
      1);
  EXPECT_EQ(figures.moving, 2);
  EXPECT_EQ(figures.still, 2);
  EXPECT_EQ(figures.left_out, 1);
  EXPECT_EQ(figures.tp, 1);
  EXPECT_EQ(figures.fp, 1);
  EXPECT_EQ(figures.fn, 1);
  EXPECT_NEAR(*figures.f1, 0.5, kExact);
  EXPECT_NEAR(*figures.area, 0.75, kExact);
}

// The object, of id 1, owns the left half of the masks; it is 5 m away, what lies behind it 9 m.
class MaskedPoints : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"mask_0", "depth_0"})
      std::filesystem::create_directories(folder_ / name);
    std::vector<std::uint8_t> ids(kSide * kSide);
    std::vector<std::uint16_t> depth_mm(kSide * kSide);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      ids[i] = i % kSide < kSide / 2 ? 1 : 0;
      depth_mm[i] = ids[i] == 1 ? 5000 : 9000;
    }
    test_support::write_png(folder_ / "mask_0/000001.png", {ids.data(), kSide, kSide, kSide});
    test_support::write_png16(folder_ / "depth_0/000001.png", depth_mm, kSide, kSide);
    truth_.folder = folder_;
    (*truth_.objects)[1][0].id = "1";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static constexpr int kSide = 300;
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("masked_points_" + std::to_string(getpid()));
  Truth truth_ = scene_of_points();
};

TEST_F(MaskedPoints, BelongToWhatTheirPixelShows) {
  // Outside of the rectangle but on the object; in it but on the background; twice on the border,
  // told apart by depth, and once not.
  const PointFigures figures = score_points(
      truth_,
      {point(20, 7.0, 1.0, true), point(160, 5.0, 1.0, true), point(150, 5.1, 1.0, true),
       point(149, 9.1, 0.1, false), point(150, 7.0, 1.0, true)},
      1);
  EXPECT_EQ(figures.moving, 2);
  EXPECT_EQ(figures.still, 2);
  EXPECT_EQ(figures.left_out, 1);
  EXPECT_EQ(figures.tp, 2);
  EXPECT_EQ(figures.fp, 1);
}

TEST_F(MaskedPoints, AtEdgesAreLeftOutWithoutDepth) {
  std::filesystem::remove_all(folder_ / "depth_0");
  EXPECT_EQ(score_points(truth_, {point(150, 5.0, 1.0, true)}, 1).left_out, 1);
}

// A wall at 9 m before a rig that rests: each track keeps an error of its own, and one varies.
TEST_F(MaskedPoints, AtRestShowWhatTheirPlacesAndDisparitiesErr) {
  constexpr double kVarying_px = 0.2, kKept_px = 0.3;
  truth_.focal_px = 500.0;
  truth_.baseline_m = 0.4;
  truth_.times_s.assign(30, 0.0);
  truth_.poses.assign(30, {});
  Record record{.estimate = {}, .poses = {}, .processed = {}, .points = {{}}, .noise = {}};
  record.noise[{8.0, 16.0}] = {.pixel_px2 = 0.02, .disparity_px2 = 0.08, .weight = 2.0};
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int frame = 1; frame < 30; ++frame) {
    truth_.poses[static_cast<std::size_t>(frame)].frame = frame;
    for (const char* name : {"mask_0", "depth_0"}) {
      const std::string to =
          std::string(name) + "/0000" + (frame < 10 ? "0" : "") + std::to_string(frame) + ".png";
      if (frame > 1) std::filesystem::copy_file(folder_ / name / "000001.png", folder_ / to);
    }
    for (int track = 1; track <= 100; ++track) {
      PointEvidence seen = point(200.0 + kVarying_px * normal(random), 9.0, 0.0, false);
      seen.frame = frame;
      seen.track = track;
      seen.v_px += kVarying_px * normal(random);
      seen.disparity_px = 500.0 * 0.4 / 9.0 + kVarying_px * normal(random) +
                          (track % 2 == 0 ? kKept_px : -kKept_px);
      record.points->push_back(seen);
    }
  }
  const std::vector<NoiseFigures> figures = score_noise(truth_, record, 1);
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_NEAR(figures[0].learnt.disparity_px, 0.2, kExact);
  EXPECT_NEAR(figures[0].learnt.pixel_px, 0.1, kExact);
  EXPECT_NEAR(figures[0].varying.disparity_px, kVarying_px, 0.02);
  EXPECT_NEAR(figures[0].varying.pixel_px, kVarying_px, 0.02);
  EXPECT_GT(figures[0].whole.disparity_px, 1.5 * kVarying_px);
  EXPECT_NEAR(figures[0].whole.pixel_px, std::sqrt(2.0) * kVarying_px, 0.03)
      << "the place of the first sight errs too";
}

TEST_F(MaskedPoints, NameTheMaskThatIsMissing) {
  std::filesystem::remove(folder_ / "mask_0/000001.png");
  try {
    (void)score_points(truth_, {point(150, 5.0, 1.0, true)}, 1);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("mask_0/000001.png"));
  }
}

TEST(Tables, AlignTheirColumns) {
  EXPECT_EQ(text_of({"T", {"", "n"}, {{"a", "1"}, {"bcd", "22"}}}),
            "T\n        n\n  a     1\n  bcd  22\n");
}

Evaluation run_of(const char* world, const char* method, double precision) {
  Evaluation e;
  e.name = world;
  e.method = method;
  e.truth = standing(5);  // 2 Hz
  e.detection.emplace();
  e.detection->precision = precision;
  e.detection->duration_s = 2.5;
  return e;
}

TEST(Tables, OfMethodsHaveARowARunAndMeanAndMedianOfEachMethod) {
  const FigureTable table =
      method_table({run_of("hall", "default", 1.0), run_of("hall", "thesis", 0.5),
                    run_of("yard", "default", 0.75)});
  const auto column = std::find(table.header.begin(), table.header.end(), "precision");
  ASSERT_NE(column, table.header.end());
  const auto at = static_cast<std::size_t>(column - table.header.begin());
  ASSERT_EQ(table.rows.size(), 7U);
  for (const auto& row : table.rows) ASSERT_EQ(row.size(), table.header.size());
  EXPECT_EQ(table.rows[0][0], "hall");
  EXPECT_EQ(table.rows[1][at], "0.500");
  EXPECT_EQ(table.rows[3][1], "default");
  EXPECT_EQ(table.rows[3][at], "0.875");
  EXPECT_EQ(table.rows[4][0], "median");
  EXPECT_EQ(table.rows[5][at], "0.500");
}

TEST(Tables, AreMarkdownForDocuments) {
  EXPECT_EQ(markdown_of({"", {"a", "b"}, {{"x", "1"}, {"y", "2"}}}),
            "| a | b |\n| --- | --: |\n| x | 1 |\n| y | 2 |\n");
}

}  // namespace
}  // namespace egomod::eval
