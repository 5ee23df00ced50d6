// SPDX-License-Identifier: Apache-2.0
#include "replay_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace egomod {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::uint64_t& count_of(PairFault fault, PipelineStatistics& pipeline) {
  return pipeline.rejected_by[static_cast<std::size_t>(fault)];
}

TEST(ReplayReport, counts_what_was_left_out_by_its_reason) {
  PipelineStatistics pipeline{.captured = 60, .rejected = 7};
  count_of(PairFault::kNoPartner, pipeline) = 4;
  count_of(PairFault::kDamaged, pipeline) = 3;
  EXPECT_THAT(losses_of(pipeline, {}, {}),
              ElementsAre("7 of 60 pairs were rejected: 4 without an image of the right camera, 3 "
                          "with a damaged image"));
}

TEST(ReplayReport, counts_images_that_the_source_lost_or_nobody_took) {
  EXPECT_THAT(losses_of({.captured = 60}, {}, {.lost_images = 3, .dropped_images = 2}),
              ElementsAre("3 images never came from the source, 2 came too late or were not taken "
                          "in time"));
}

TEST(ReplayReport, counts_damaged_messages_and_what_was_held_back) {
  EXPECT_THAT(losses_of({}, {.not_finite = 2}, {.damaged_messages = 5}),
              ElementsAre(HasSubstr("5 image messages were too damaged"),
                          HasSubstr("2 estimates were not finite and held back")));
  EXPECT_THAT(losses_of({.captured = 60}, {}, {}), IsEmpty());
}

TEST(ReplayReport, tells_cause_and_remedy_when_no_pair_could_be_used) {
  PipelineStatistics pipeline{.captured = 5, .rejected = 5};
  count_of(PairFault::kNoPartner, pipeline) = 5;
  EXPECT_THAT(why_nothing_was_used(pipeline), HasSubstr("capture.right_channel"));
  pipeline.rejected_by = {};
  count_of(PairFault::kSkew, pipeline) = 5;
  pipeline.least_rejected_skew = 99s;
  EXPECT_THAT(why_nothing_was_used(pipeline), HasSubstr("the nearest right image is 99 s from"));
}

TEST(ReplayReport, one_usable_pair_is_enough) {
  EXPECT_EQ(why_nothing_was_used({.captured = 5, .rejected = 4}), "");
  EXPECT_EQ(why_nothing_was_used({}), "") << "stopped before the first pair";
}

}  // namespace
}  // namespace egomod
