// SPDX-License-Identifier: Apache-2.0
#include "bus_requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <egomod/blackbox_t.hpp>
#include <egomod/calibration_t.hpp>
#include <lcm/lcm-cpp.hpp>

namespace egomod {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Takes a positive baseline.
class CalibrationTaker final : public FrameSource {
 public:
  SourceState next(StereoPair&, std::stop_token) override { return SourceState::kEnd; }
  [[nodiscard]] bool is_replay() const override { return false; }
  void set_calibration(const Calibration& calibration) override {
    if (!(calibration.camera.baseline_m > 0.0)) throw SourceError("calibration: the baseline");
    baseline_m = calibration.camera.baseline_m;
  }
  double baseline_m = 0.0;
};

class BusRequestsTest : public ::testing::Test {
 protected:
  // memq delivers one message a call and wakes the receiver through a pipe.
  std::vector<std::string> answers() { return requests_.handle(); }

  lcm::LCM bus_{"memq://"};
  CalibrationTaker source_;
  BusRequests requests_{bus_, source_};
};

TEST_F(BusRequestsTest, a_calibration_is_handed_to_the_source) {
  EXPECT_THAT(answers(), IsEmpty());
  calibration_t message{};
  message.baseline = 0.25;
  bus_.publish("EGOMOD_CALIBRATION_SET", &message);
  EXPECT_THAT(answers(), ElementsAre(HasSubstr("taken, from the next pair on")));
  EXPECT_EQ(source_.baseline_m, 0.25);
  EXPECT_EQ(requests_.calibrations_refused(), 0U);
}

TEST_F(BusRequestsTest, a_wrong_calibration_is_refused_and_counted) {
  calibration_t message{};
  message.baseline = -1.0;
  bus_.publish("EGOMOD_CALIBRATION_SET", &message);
  EXPECT_THAT(answers(), ElementsAre(HasSubstr("baseline; the old calibration stays")));
  bus_.publish("EGOMOD_CALIBRATION_SET", "garbage", 7);
  EXPECT_THAT(answers(), ElementsAre(HasSubstr("is not an egomod.calibration_t")));
  EXPECT_EQ(requests_.calibrations_refused(), 2U);
  EXPECT_EQ(source_.baseline_m, 0.0);
}

TEST_F(BusRequestsTest, a_request_for_a_black_box_is_answered) {
  blackbox_t message{};
  bus_.publish("EGOMOD_BLACKBOX", &message);
  EXPECT_THAT(answers(), ElementsAre(HasSubstr("keeps no black box")));
}

}  // namespace
}  // namespace egomod
