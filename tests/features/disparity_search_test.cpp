// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/disparity_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "egomod/features/corners.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 120;

struct Rig {
  Image left, right;
};

struct Outcome {
  int found = 0, wrong = 0, weak = 0, ambiguous = 0, outside = 0;
  [[nodiscard]] int all() const { return found + wrong + weak + ambiguous + outside; }
};

// Disparities further than one pixel from `truth_px(u, v)` are wrong.
template <class Truth>
Outcome run(const Rig& rig, Truth truth_px, int min_u_px, const DisparityConfig& config = {},
            std::optional<PixelPosition> right_shift = {}) {
  Pyramid left, right;
  left.build(rig.left.view(), 2);
  right.build(rig.right.view(), 2);
  CornerDetector detector({});
  std::vector<Corner> corners;
  detector.detect(rig.left.view(), {}, 1.0F, corners);
  std::vector<PixelPosition> points;
  for (const Corner& c : corners)
    if (c.position.u_px >= min_u_px) points.push_back(c.position);
  std::vector<DisparityMatch> matches(points.size());
  DisparitySearch search(config);
  std::vector<PixelPosition> shifts;
  if (right_shift) shifts.resize(points.size(), *right_shift);
  search.search(left, right, points, matches, shifts);
  Outcome outcome;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DisparityMatch& m = matches[i];
    const double error = m.disparity_px - truth_px(points[i].u_px, points[i].v_px);
    if (m.status == MatchStatus::kFound) ++(std::abs(error) <= 1.0 ? outcome.found : outcome.wrong);
    outcome.weak += m.status == MatchStatus::kWeak;
    outcome.ambiguous += m.status == MatchStatus::kAmbiguous;
    outcome.outside += m.status == MatchStatus::kOutside;
  }
  return outcome;
}

Rig shifted_poster(double disparity_px, double gain = 1.0, double offset = 0.0) {
  const testing::SpottedTexture texture(kWidth_px + 300, kHeight_px, 17, 60.0, 5.0);
  return {testing::painted(kWidth_px, kHeight_px, texture),
          testing::painted(kWidth_px, kHeight_px, [&](int u, int v) {
            return gain * texture(u + disparity_px, v) + offset;
          })};
}

TEST(DisparitySearchTest, FindsEveryDisparityUpToTheLimit) {
  for (const double disparity : {0.0, 0.5, 1.0, 7.0, 60.3, 149.0, 200.5, 255.0, 256.0}) {
    const Outcome o = run(
        shifted_poster(disparity), [&](int, int) { return disparity; }, 280);
    ASSERT_GT(o.all(), 100) << disparity;
    EXPECT_EQ(o.wrong, 0) << disparity;
    EXPECT_GE(o.found, 0.95 * o.all()) << disparity << " weak " << o.weak << " ambiguous "
                                       << o.ambiguous << " outside " << o.outside;
  }
}

TEST(DisparitySearchTest, DoesNotMindGainAndOffset) {
  const Outcome o = run(
      shifted_poster(40.0, 0.7, 25.0), [](int, int) { return 40.0; }, 60);
  EXPECT_EQ(o.wrong, 0);
  EXPECT_GE(o.found, 0.95 * o.all());
}

TEST(DisparitySearchTest, FollowsASlantedSurface) {
  // A floor: 0.3 px of disparity more in each row.
  const auto truth = [](int, int v) { return 20.0 + 0.3 * v; };
  const testing::SpottedTexture texture(kWidth_px + 300, kHeight_px, 23, 60.0, 5.0);
  const Rig rig{testing::painted(kWidth_px, kHeight_px, texture),
                testing::painted(kWidth_px, kHeight_px,
                                 [&](int u, int v) { return texture(u + truth(0, v), v); })};
  const Outcome o = run(rig, truth, 80);
  EXPECT_LE(o.wrong, 0.01 * o.all());
  EXPECT_GE(o.found, 0.85 * o.all());
}

TEST(DisparitySearchTest, RefusesRepeatedTexture) {
  const auto grid = [](double u, double v) {
    return 120.0 + 50.0 * std::sin(2.0 * M_PI * u / 16.0) * std::sin(2.0 * M_PI * v / 16.0);
  };
  const Rig rig{
      testing::painted(kWidth_px, kHeight_px, grid),
      testing::painted(kWidth_px, kHeight_px, [&](int u, int v) { return grid(u + 24.0, v); })};
  const Outcome o = run(
      rig, [](int, int) { return 24.0; }, 200);
  ASSERT_GT(o.all(), 50);
  EXPECT_EQ(o.found + o.wrong, 0);
  EXPECT_GE(o.ambiguous, 0.95 * o.all());
}

TEST(DisparitySearchTest, RefusesWhatTheOtherImageDoesNotShow) {
  const testing::SpottedTexture a(kWidth_px, kHeight_px, 31, 60.0, 5.0),
      b(kWidth_px, kHeight_px, 32, 60.0, 5.0);
  const Rig rig{testing::painted(kWidth_px, kHeight_px, a),
                testing::painted(kWidth_px, kHeight_px, b)};
  const Outcome o = run(
      rig, [](int, int) { return -100.0; }, 280);
  // Among 3 x 258 places a few look alike by chance; those are for the caller's check from right to
  // left.
  EXPECT_LE(o.wrong, 0.12 * o.all());
}

// A wall of bricks, all a little different, behind something that hides some of them from the right
// camera: what is hidden is like another brick that both cameras see.
TEST(DisparitySearchTest, RefusesWhatIsHiddenWhereALookAlikeIsShown) {
  constexpr double kWall_px = 30.0;
  constexpr int kBrick_px = 90;
  const testing::SpottedTexture alike(kBrick_px + 40, kHeight_px, 33, 60.0, 5.0),
      own(kWidth_px + 100, kHeight_px, 34, 18.0, 5.0), hiding(kWidth_px, kHeight_px, 35, 60.0, 5.0);
  const auto wall = [&](double u, double v) {
    return alike(20.0 + std::fmod(u, kBrick_px), v) + own(u, v) - 120.0;
  };
  const auto hides = [](double u_right) { return u_right > 200.0 && u_right < 280.0; };
  const Rig rig{testing::painted(kWidth_px, kHeight_px, wall),
                testing::painted(kWidth_px, kHeight_px, [&](int u, int v) {
                  return hides(u) ? hiding(u, v) : wall(u + kWall_px, v);
                })};
  const auto truth = [&](int u, int) { return hides(u - kWall_px) ? -100.0 : kWall_px; };
  const Outcome o = run(rig, truth, 160, {.max_disparity_px = 150});
  ASSERT_GT(o.all(), 150);
  EXPECT_LE(o.wrong, 0.01 * o.all());
  EXPECT_GE(o.found, 0.5 * o.all());
}

TEST(DisparitySearchTest, ToleratesOneRowOfMisalignment) {
  const testing::SpottedTexture texture(kWidth_px + 300, kHeight_px + 4, 41);
  for (const int rows : {-1, 1}) {
    const Rig rig{testing::painted(kWidth_px, kHeight_px, texture),
                  testing::painted(kWidth_px, kHeight_px,
                                   [&](int u, int v) { return texture(u + 33.0, v - rows); })};
    const Outcome o = run(
        rig, [](int, int) { return 33.0; }, 60);
    EXPECT_EQ(o.wrong, 0);
    EXPECT_GE(o.found, 0.9 * o.all());
  }
}

TEST(DisparitySearchTest, SeeksWhereTheRightImageIsKnownToBeDisplaced) {
  const testing::SpottedTexture texture(kWidth_px + 300, kHeight_px + 8, 43);
  for (const PixelPosition shift : {PixelPosition{-5, 3}, PixelPosition{8, -4}}) {
    const Rig rig{testing::painted(kWidth_px, kHeight_px, texture),
                  testing::painted(kWidth_px, kHeight_px, [&](int u, int v) {
                    return texture(u + 33.0 - shift.u_px, v - shift.v_px);
                  })};
    const Outcome o = run(
        rig, [](int, int) { return 33.0; }, 60, {}, shift);
    EXPECT_EQ(o.wrong, 0);
    EXPECT_GE(o.found, 0.9 * o.all());
  }
}

TEST(DisparitySearchTest, SaysOutsideAtTheBorder) {
  const Rig rig = shifted_poster(3.0);
  Pyramid left, right;
  left.build(rig.left.view(), 2);
  right.build(rig.right.view(), 2);
  const std::vector<PixelPosition> points{{2, 50}, {637, 50}, {300, 1}, {300, 118}};
  std::vector<DisparityMatch> matches(points.size());
  DisparitySearch({}).search(left, right, points, matches);
  for (const DisparityMatch& m : matches) EXPECT_EQ(m.status, MatchStatus::kOutside);
}

}  // namespace
}  // namespace egomod
