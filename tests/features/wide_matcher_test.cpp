// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/wide_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "test_images.hpp"

namespace egomod {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;

std::vector<DescribedPoint> described(const Image& image) {
  Pyramid pyramid;
  pyramid.build(image.view(), 2);
  CornerDetector detector({});
  std::vector<Corner> corners;
  detector.detect(image.view(), {}, 1.0F, corners);
  std::vector<DescribedPoint> points;
  for (const Corner& c : corners) {
    DescribedPoint p{
        .position = {static_cast<float>(c.position.u_px), static_cast<float>(c.position.v_px)},
        .kind = c.kind,
        .descriptor = {}};
    if (describe(pyramid, p.position, p.descriptor)) points.push_back(p);
  }
  return points;
}

struct View {
  double scale = 1.0, du_px = 0.0, dv_px = 0.0, gain = 1.0, roll_rad = 0.0;
  // Where the texture point that this view shows at (u, v) lies.
  [[nodiscard]] std::pair<double, double> source(double u, double v) const {
    const double x = (u - 320.0 - du_px) / scale, y = (v - 240.0 - dv_px) / scale;
    const double c = std::cos(roll_rad), s = std::sin(roll_rad);
    return {620.0 + c * x + s * y, 440.0 - s * x + c * y};
  }
};

Image seen(const testing::SpottedTexture& texture, const View& view) {
  return testing::painted(kWidth_px, kHeight_px, [&](int u, int v) {
    const auto [x, y] = view.source(u, v);
    return 20.0 + view.gain * (texture(x, y) - 20.0);
  });
}

struct Outcome {
  int right = 0, wrong = 0, olds = 0;
};

Outcome run(const View& before, const View& after, float radius_px) {
  constexpr double kSamePoint_px = 4.0;
  const testing::SpottedTexture texture(1240, 880, 77, 70.0, 9.0);
  const auto olds = described(seen(texture, before)), news = described(seen(texture, after));
  std::vector<WideMatch> matches(olds.size());
  WideMatcher matcher({});
  matcher.match(olds, news, radius_px, matches);
  Outcome outcome{.olds = static_cast<int>(olds.size())};
  for (std::size_t i = 0; i < olds.size(); ++i) {
    if (matches[i].candidate < 0) continue;
    const ImagePoint a = olds[i].position;
    const ImagePoint b = news[static_cast<std::size_t>(matches[i].candidate)].position;
    const auto [xa, ya] = before.source(a.u_px, a.v_px);
    const auto [xb, yb] = after.source(b.u_px, b.v_px);
    ++(std::hypot(xa - xb, ya - yb) <= kSamePoint_px ? outcome.right : outcome.wrong);
  }
  return outcome;
}

TEST(WideMatcherTest, FindsPointsThatMovedFar) {
  const Outcome o = run({}, {.du_px = -220.0, .dv_px = 15.0, .gain = 0.8}, 400.0F);
  ASSERT_GT(o.olds, 500);
  EXPECT_GE(o.right, 0.4 * o.olds);  // a third of them has left the image
  EXPECT_LE(o.wrong, 0.03 * o.right);
}

TEST(WideMatcherTest, ToleratesAChangeOfScale) {
  for (const double scale : {1.0 / 1.4, 1.0 / 1.2, 1.2, 1.4}) {
    const Outcome o = run({}, {.scale = scale, .du_px = 60.0}, 300.0F);
    EXPECT_GE(o.right, 0.12 * o.olds) << scale;
    EXPECT_LE(o.wrong, 0.15 * o.right) << scale;
  }
}

TEST(WideMatcherTest, ToleratesALittleRoll) {
  const Outcome o = run({}, {.du_px = 100.0, .roll_rad = 0.08}, 400.0F);
  EXPECT_GE(o.right, 0.3 * o.olds);
  EXPECT_LE(o.wrong, 0.05 * o.right);
}

TEST(WideMatcherTest, KeepsToTheRadius) {
  const Outcome o = run({}, {.du_px = 150.0}, 100.0F);
  EXPECT_EQ(o.right, 0);
  EXPECT_LE(o.wrong, 0.05 * o.olds);  // look-alikes
}

DescribedPoint point(float u, float v, int grey, CornerKind kind = CornerKind::kDark) {
  DescribedPoint p{.position = {u, v}, .kind = kind, .descriptor = {}};
  p.descriptor.narrow.fill(static_cast<std::uint8_t>(grey));
  p.descriptor.wide.fill(255);
  return p;
}

TEST(WideMatcherTest, RefusesWhatIsNotClearOrNotMutualOrOfTheOtherKind) {
  WideMatcher matcher({});
  std::vector<WideMatch> match(1);
  const auto run_one = [&](const std::vector<DescribedPoint>& candidates) {
    const std::vector<DescribedPoint> olds{point(50, 50, 100)};
    matcher.match(olds, candidates, 40.0F, match);
    return match[0].candidate;
  };
  EXPECT_EQ(run_one({point(60, 60, 102)}), 0);
  EXPECT_EQ(run_one({point(60, 60, 102), point(30, 30, 140)}), 0);
  EXPECT_EQ(run_one({point(60, 60, 102), point(30, 30, 102)}), -1);
  EXPECT_EQ(run_one({point(60, 60, 102, CornerKind::kBright)}), -1);
  EXPECT_EQ(run_one({point(60, 60, 140)}), -1);  // 32 * 40 apart
  EXPECT_EQ(run_one({}), -1);

  const std::vector<DescribedPoint> olds{point(50, 50, 100), point(55, 50, 101)};
  std::vector<WideMatch> matches(2);
  matcher.match(olds, std::vector{point(60, 60, 101)}, 40.0F, matches);
  EXPECT_EQ(matches[0].candidate, -1);
  EXPECT_EQ(matches[1].candidate, 0);
}

int distance(const auto& a, const auto& b) {
  int total = 0;
  for (std::size_t i = 0; i < a.size(); ++i) total += std::abs(a[i] - b[i]);
  return total;
}

TEST(DescriptorTest, DoesNotMindGainAndOffset) {
  constexpr int kRounding = 130;  // of grey values, 32 bytes
  const testing::SpottedTexture texture(100, 100, 4);
  const Image a = testing::painted(100, 100, texture);
  const Image b =
      testing::painted(100, 100, [&](int u, int v) { return 10 + 0.6 * texture(u, v); });
  Pyramid pa, pb;
  pa.build(a.view(), 2);
  pb.build(b.view(), 2);
  Descriptor da, db;
  ASSERT_TRUE(describe(pa, {50.0F, 50.0F}, da));
  ASSERT_TRUE(describe(pb, {50.0F, 50.0F}, db));
  EXPECT_LE(distance(da.narrow, db.narrow), kRounding);
  EXPECT_LE(distance(da.wide, db.wide), kRounding);
}

TEST(DescriptorTest, RefusesFlatPlacesAndTheBorder) {
  const Image wall = testing::flat_image(100, 100, 90.0, 0.0);
  const testing::SpottedTexture texture(100, 100, 4);
  const Image poster = testing::painted(100, 100, texture);
  Pyramid flat, textured;
  flat.build(wall.view(), 2);
  textured.build(poster.view(), 2);
  Descriptor d;
  EXPECT_FALSE(describe(flat, {50.0F, 50.0F}, d));
  EXPECT_FALSE(describe(textured, {15.0F, 50.0F}, d));
  EXPECT_FALSE(describe(textured, {50.0F, 84.0F}, d));
}

}  // namespace
}  // namespace egomod
