// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "health.hpp"
#include "logging.hpp"

namespace egomod {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class ProgressTest : public ::testing::Test {
 protected:
  // 100 pairs, one in each `step`.
  std::string run(bool is_terminal, Progress::Clock::duration step) {
    char* text = nullptr;
    std::size_t size = 0;
    std::FILE* out = open_memstream(&text, &size);
    const auto begin = Progress::Clock::now();
    Progress progress("work", "pairs", 100, out, is_terminal);
    for (std::uint64_t done = 1; done <= 100; ++done) {
      progress.update(done, begin + step * static_cast<int>(done));
    }
    progress.finish(100, begin + step * 100);
    std::fclose(out);
    const std::string result(text, size);
    std::free(text);
    return result;
  }
};

TEST_F(ProgressTest, draws_a_bar_with_rate_and_time_left_on_a_terminal) {
  const std::string text = run(true, 500ms);
  EXPECT_THAT(text,
              HasSubstr("\rwork [###############...............]  50 %  50 of 100 pairs, 2.0 a "
                        "second, 0:25 left"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST_F(ProgressTest, writes_sparse_lines_elsewhere) {
  const std::string text = run(false, 500ms);  // 50 s: every 10 s
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 4);
  EXPECT_LE(lines, 6);
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST_F(ProgressTest, says_nothing_about_short_work) { EXPECT_EQ(run(false, 10ms), ""); }

TEST(WarningLimiter, holds_repetitions_back_and_counts_them_whatever_their_figures) {
  WarningLimiter limiter(10.0);
  const auto begin = WarningLimiter::Clock::now();
  EXPECT_EQ(limiter.passed("3 pairs dropped", begin), "3 pairs dropped");
  EXPECT_EQ(limiter.passed("4 pairs dropped", begin + 1s), "");
  EXPECT_EQ(limiter.passed("bus gone", begin + 1s), "bus gone");
  EXPECT_EQ(limiter.passed("5 pairs dropped", begin + 11s),
            "5 pairs dropped (1 more like this before)");
}

TEST(HealthReporter, reports_each_second_and_at_once_when_a_fault_comes) {
  HealthReporter reporter;
  health_t message;
  HealthInputs inputs;
  const auto begin = HealthReporter::Clock::now();
  inputs.pipeline.captured = inputs.pipeline.published = 1;
  ASSERT_TRUE(reporter.report(inputs, begin, message));
  EXPECT_EQ(message.state, health_t::STATE_RUNNING);
  EXPECT_FALSE(reporter.report(inputs, begin + 250ms, message));
  inputs.pipeline.captured = 10;
  inputs.pipeline.dropped = 5;
  EXPECT_FALSE(reporter.report(inputs, begin + 400ms, message)) << "they were rejected already";
  inputs.pipeline.dropped_usable = 2;
  ASSERT_TRUE(reporter.report(inputs, begin + 500ms, message));
  EXPECT_EQ(message.state, health_t::STATE_DEGRADED);
  EXPECT_EQ(message.fault_bits, health_t::FAULT_PAIRS_DROPPED);
  ASSERT_EQ(message.n_faults, 1);
  EXPECT_THAT(message.faults[0], HasSubstr("2 pairs dropped"));
  ASSERT_TRUE(reporter.report(inputs, begin + 1500ms, message));
  ASSERT_TRUE(reporter.report(inputs, begin + 3s, message));
  EXPECT_EQ(message.fault_bits, health_t::FAULT_NO_PAIRS);
}

TEST(HealthReporter, names_what_is_wrong_with_the_calibration) {
  HealthReporter reporter;
  health_t message;
  HealthInputs inputs;
  inputs.pipeline.captured = inputs.pipeline.published = 1;
  inputs.run.right_turn = {.is_off = true, .turn_rad = {5e-3, -4e-3, 3e-3}, .yaw_sigma_rad = 1e-3};
  ASSERT_TRUE(reporter.report(inputs, HealthReporter::Clock::now(), message));
  EXPECT_EQ(message.state, health_t::STATE_DEGRADED);
  EXPECT_EQ(message.fault_bits, health_t::FAULT_MISCALIBRATED);
  ASSERT_EQ(message.n_faults, 1);
  EXPECT_THAT(message.faults[0], HasSubstr("0.29° in pitch, -0.23° (± 0.06°) in yaw"));
}

TEST(HealthReporter, reports_lost_images_refused_calibrations_and_the_failure_of_the_run) {
  HealthReporter reporter;
  health_t message;
  HealthInputs inputs;
  const auto begin = HealthReporter::Clock::now();
  inputs.pipeline.captured = inputs.pipeline.published = 1;
  inputs.source.lost_images = 3;
  inputs.calibrations_refused = 1;
  ASSERT_TRUE(reporter.report(inputs, begin, message));
  EXPECT_EQ(message.fault_bits, health_t::FAULT_CALIBRATION | health_t::FAULT_IMAGES);
  EXPECT_EQ(message.lost_images, 3);
  EXPECT_THAT(message.faults[0], HasSubstr("1 new calibrations were refused"));
  inputs.failed = true;
  ASSERT_TRUE(reporter.report(inputs, begin + 10ms, message));
  EXPECT_EQ(message.state, health_t::STATE_FAILED);
}

}  // namespace
}  // namespace egomod
