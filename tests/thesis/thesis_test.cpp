// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "case_fixture.hpp"
#include "cases.hpp"
#include "findings.hpp"
#include "temporary_folder.hpp"
#include "threshold.hpp"

namespace egomod::thesis {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPrinted = 2e-6;  // the last digit of the files that a record becomes

class Thesis : public ::testing::Test {
 protected:
  void SetUp() override { write_case(folder_.path()); }
  std::string error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  std::string error_of_case() {
    return error_of([&] { (void)read_case(folder_.path()); });
  }

  eval::TemporaryFolder folder_;
};

TEST_F(Thesis, TheTargetIsSeenInTheFixedFrame) {
  const Case one = read_case(folder_.path());
  const std::vector<Sighting> truth = true_sightings(one.standard.truth);
  ASSERT_EQ(truth.size(), 31U);
  EXPECT_NEAR(truth[20].position_m.x(), -1.0, kPrinted);
  EXPECT_NEAR(truth[20].position_m.z(), 7.0, kPrinted);
  EXPECT_NEAR(truth[20].depth_m, 6.0, kPrinted);
  EXPECT_NEAR(truth[20].right_m - truth[20].left_m, 200.0 * 6.0 / 500.0, 1e-4);
  EXPECT_NEAR(truth[20].left_m, -1.0 - 100.0 * 6.0 / 500.0, 1e-4);

  const std::vector<Sighting> found = sightings(one.standard);
  ASSERT_EQ(found.size(), 26U);
  EXPECT_EQ(found.front().frame, 5);
  EXPECT_NEAR(found.front().position_m.z(), 5.6, kPrinted);
  EXPECT_NEAR(found.front().position_error_m, 0.1, kPrinted);
  EXPECT_NEAR(found.front().velocity_error_mps, 0.25, kPrinted);
}

TEST_F(Thesis, OnlyItsOwnPairsCountForTheThesissMethod) {
  const Case one = read_case(folder_.path());
  EXPECT_EQ(sightings(one.thesis).size(), 3U);
  EXPECT_EQ(one.thesis.detection->frames, 3);
  EXPECT_NEAR(*one.thesis.detection->recall, 1.0, 1e-12);
  EXPECT_NEAR(*one.standard.detection->recall, 26.0 / 30.0, 1e-12);
  const auto speeds = rig_speeds(one.thesis.estimate.poses, one.thesis.truth.times_s);
  ASSERT_EQ(speeds.size(), 3U);
  EXPECT_NEAR(speeds[0].time_s, 1.0, kPrinted);
  EXPECT_NEAR(speeds[0].forward_mps, 0.5, kPrinted);
}

TEST_F(Thesis, TheTimeOfAPairIsThatOfItsStages) {
  const Case one = read_case(folder_.path());
  EXPECT_NEAR(*pair_ms(one.thesis), 2.0, 1e-6);
  EXPECT_NEAR(*pair_ms(one.standard), 6.0, 1e-6);
}

// Speeds of 0.1 and 0.5 m/s: sigma is the speed by the root of 2.
TEST_F(Thesis, TheThresholdIsThatOfTheSamples) {
  const std::vector<ThresholdFit> fits = fit_thresholds({folder_.path(), folder_.path()});
  const ThresholdFit& fit = fits.front();
  EXPECT_EQ(fit.labels.static_mps.size(), 8U);
  EXPECT_NEAR(fit.model.classifier.sigma_static_mps, 0.1 / std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(fit.model.classifier.sigma_moving_mps, 0.5 / std::sqrt(2.0), 1e-6);
  // x^2 = ln(25) / (1/0.01 - 1/0.25)
  EXPECT_NEAR(*fit.even_mps, std::sqrt(std::log(25.0) / 96.0), 1e-6);
  EXPECT_NEAR(*fit.certain_mps, std::sqrt((std::log(25.0) + std::log(99.0)) / 96.0), 1e-6);
}

// One mismatch among a hundred points: a draw of ten holds it once in ten times.
TEST(ThresholdSpread, IsThatOfTheDraws) {
  fit::Labels labels{std::vector<double>(99, 0.1), std::vector<double>(100, 0.5)};
  const ThresholdSpread even = spread_of(labels, 10);
  EXPECT_EQ(even.draws, 1000);
  EXPECT_NEAR(even.low_mps, std::sqrt(std::log(25.0) / 96.0), 1e-12);
  EXPECT_NEAR(even.high_mps, even.low_mps, 1e-12);
  labels.static_mps.push_back(1.0);
  const ThresholdSpread torn = spread_of(labels, 10);
  EXPECT_NEAR(torn.median_mps, even.median_mps, 1e-12);
  EXPECT_GT(torn.high_mps, 1.5 * even.high_mps);
  EXPECT_EQ(torn.high_mps, spread_of(labels, 10).high_mps);
}

TEST_F(Thesis, TheComparisonHoldsWhatWasMeasured) {
  const Cases cases{.still = read_case(folder_.path()),
                    .moving = read_case(folder_.path()),
                    .range = read_case(folder_.path()),
                    .range_narrow_gate = read_thesis_run(folder_.path(), "thesis-narrow"),
                    .near = {read_thesis_run(folder_.path(), "thesis")},
                    .near_wide_search = {read_thesis_run(folder_.path(), "thesis-wide")}};
  const eval::FigureTable table = comparison_table(cases, fit_thresholds({folder_.path()}));
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.header.size());
  EXPECT_THAT(table.rows, Contains(ElementsAre("range", "0.866 to 13.537 m", "5.500 to 6.500 m",
                                               "5.250 to 6.500 m")));
  EXPECT_THAT(table.rows,
              Contains(ElementsAre("time of a pair, 800x600", "0.41 s", "2.0 ms", "6.0 ms")));
}

TEST_F(Thesis, WhatIsMissingIsNamedWithItsRemedy) {
  const auto remove = [&](const char* name) {
    std::filesystem::remove_all(folder_.path() + "/" + name);
  };
  remove("default.lcmlog");
  EXPECT_THAT(error_of_case(), HasSubstr("default.lcmlog: is not there; tools/reproduce-thesis"));
  remove("truth");
  EXPECT_THAT(error_of_case(), HasSubstr("/truth: is not there; tools/reproduce-thesis"));
}

TEST_F(Thesis, ATruthWithoutATargetIsRefused) {
  const std::string file = folder_.path() + "/truth/objects.csv";
  std::string header;
  std::getline(std::ifstream(file), header);
  std::ofstream(file) << header << '\n';
  EXPECT_THAT(error_of_case(), HasSubstr("/truth: shows no moving target"));
}

}  // namespace
}  // namespace egomod::thesis
