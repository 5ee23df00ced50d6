// SPDX-License-Identifier: Apache-2.0
#include "run_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace egomod {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A pair in which object 7 is seen in that state.
Frame frame_with(ObjectState state, double speed_mps, double speed_sigma_mps) {
  Frame frame;
  frame.objects.has_run = true;
  frame.objects.objects.resize(1);
  MovingObject& object = frame.objects.objects.front();
  object.id = 7;
  object.state = state;
  object.speed_mps = speed_mps;
  object.speed_sigma_mps = speed_sigma_mps;
  return frame;
}

TEST(RunSummary, tells_the_speed_of_each_object_with_its_error_in_both_units) {
  RunSummary summary;
  summary.add(frame_with(ObjectState::kMoving, 9.0, 0.3));
  summary.add(frame_with(ObjectState::kMoving, 11.0, 0.4));
  const std::string text = summary_text(summary.figures(), {}, 1.0, "");
  EXPECT_THAT(text, HasSubstr("speed, m/s"));
  EXPECT_THAT(text, HasSubstr("10.00 ± 0.35 "));
  EXPECT_THAT(text, HasSubstr("36.0 ±  1.3\n"));
}

TEST(RunSummary, counts_no_speed_of_what_is_not_seen_to_move) {
  RunSummary summary;
  summary.add(frame_with(ObjectState::kMoving, 2.0, 0.1));
  summary.add(frame_with(ObjectState::kCoasting, 9.0, 3.0));
  summary.add(frame_with(ObjectState::kStopped, 0.0, 0.1));
  EXPECT_THAT(summary_text(summary.figures(), {}, 1.0, ""), HasSubstr(" 2.00 ± 0.10 "));
  RunSummary nothing;
  nothing.add(frame_with(ObjectState::kTentative, 9.0, 3.0));
  EXPECT_THAT(summary_text(nothing.figures(), {}, 1.0, ""), Not(HasSubstr("km/h")));
}

}  // namespace
}  // namespace egomod
