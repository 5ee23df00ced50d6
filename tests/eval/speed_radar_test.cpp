// SPDX-License-Identifier: Apache-2.0
#include "speed_radar.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "evaluation.hpp"
#include "figure_tables.hpp"
#include "json.hpp"

namespace egomod::eval {
namespace {

using ::testing::HasSubstr;

constexpr double kExact = 1e-9;

// 10 m/s ahead; the reported direction does not count, only its speed.
Match seen(const char* id, double speed_mps, std::optional<double> sigma_mps) {
  Match match;
  match.truth.id = id;
  match.truth.velocity_mps = {0.0, 0.0, 10.0};
  match.estimate.velocity_mps = {speed_mps, 0.0, 0.0};
  match.estimate.speed_sigma_mps = sigma_mps;
  return match;
}

// One pair off by half of its error bar, one by twice.
std::vector<Match> half_and_twice() { return {seen("4", 10.25, 0.5), seen("4", 8.5, 0.75)}; }

TEST(SpeedRadar, IsWorkedOutByHand) {
  const auto radar = score_speeds(half_and_twice());
  ASSERT_TRUE(radar);
  const SpeedFigures& s = radar->objects.at("4");
  EXPECT_EQ(s.pairs, 2U);
  EXPECT_NEAR(s.true_mps, 10.0, kExact);
  EXPECT_NEAR(s.mean_mps, 9.375, kExact);
  EXPECT_NEAR(s.rmse_mps, std::sqrt((0.0625 + 2.25) / 2.0), kExact);
  EXPECT_NEAR(s.sigma_mps.value(), 0.625, kExact);
  EXPECT_NEAR(s.sigma_kmh().value(), 3.6 * s.sigma_mps.value(), kExact);
  EXPECT_NEAR(s.within_sigma.value(), 0.5, kExact);
  EXPECT_NEAR(s.error2_by_variance.value(), (0.25 + 4.0) / 2.0, kExact);
}

TEST(SpeedRadar, TellsObjectsApartAndSumsThemUp) {
  const auto radar =
      score_speeds({seen("4", 10.0, 0.1), seen("5", 12.0, 0.1), seen("5", std::nan(""), 0.1)});
  EXPECT_EQ(radar->objects.size(), 2U);
  EXPECT_NEAR(radar->objects.at("5").mean_mps, 12.0, kExact);
  EXPECT_EQ(radar->all.pairs, 2U);
  EXPECT_NEAR(radar->all.mean_mps, 11.0, kExact);
  EXPECT_FALSE(score_speeds({}));
}

// As of an export, or of a method that knows no errors.
TEST(SpeedRadar, HasNoErrorBarWhereNoneIsReported) {
  for (const std::optional<double> sigma_mps : {std::optional<double>(), std::optional(0.0)}) {
    const auto radar = score_speeds({seen("4", 10.5, sigma_mps)});
    EXPECT_NEAR(radar->all.rmse_mps, 0.5, kExact);
    EXPECT_FALSE(radar->all.sigma_mps);
    EXPECT_FALSE(radar->all.within_sigma);
    EXPECT_FALSE(radar->all.error2_by_variance);
  }
}

TEST(SpeedRadar, IsReportedInBothUnits) {
  Evaluation evaluation;
  evaluation.detection.emplace();
  evaluation.speed_radar = score_speeds(half_and_twice());
  std::string text;
  for (const FigureTable& table : figure_tables(evaluation)) text += text_of(table);
  EXPECT_THAT(text, HasSubstr("9.375 ± 0.625"));
  EXPECT_THAT(text, HasSubstr("33.75 ± 2.25"));
  EXPECT_THAT(text, HasSubstr("50 %"));
  const std::string json = json_of({evaluation});
  EXPECT_THAT(json, HasSubstr("\"speed_radar\": {\"all\": {\"n\": 2, "));
  EXPECT_THAT(json, HasSubstr("\"speed_km_h\": 33.75, "));
  EXPECT_THAT(json, HasSubstr("\"within_sigma\": 0.5, \"mean_error2_by_variance\": 2.125"));
}

}  // namespace
}  // namespace egomod::eval
