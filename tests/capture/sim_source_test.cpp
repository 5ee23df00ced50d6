// SPDX-License-Identifier: Apache-2.0
// The source `sim` with a fake of egomod-sim at its other end, which needs no OpenGL.
#include "capture/sim_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <egomod/odometry_t.hpp>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <fstream>
#include <thread>

#include "counted_new.hpp"
#include "fake_simulator.hpp"

namespace egomod {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Longer than a busy machine needs to start a program, and no longer than a test may take.
constexpr auto kPatience = 20s;

std::unique_ptr<FrameSource> open(const std::string& world, const CaptureConfig& config = {},
                                  std::chrono::milliseconds patience = kPatience) {
  return open_sim_source({.program = FAKE_SIMULATOR, .world = world, .patience = patience}, config);
}

// Why it cannot be opened.
std::string refusal(const std::string& world) {
  try {
    static_cast<void>(open(world));
  } catch (const SourceError& problem) {
    return problem.what();
  }
  return "none";
}

// Why its third pair never comes, after two good ones.
std::string failure(const std::string& world, std::chrono::milliseconds patience = kPatience) {
  const auto source = open(world, {}, patience);
  StereoPair pair;
  for (int i = 0; i < 2; ++i) EXPECT_EQ(source->next(pair, {}), SourceState::kPair) << world;
  EXPECT_EQ(source->next(pair, {}), SourceState::kFailed) << world;
  return source->error();
}

template <typename Message>
Message decoded(const EnclosedMessage& message) {
  Message result;
  EXPECT_GT(result.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size())), 0);
  return result;
}

TEST(SimSource, HandsOutEachPairWithItsTimesItsCalibrationAndTheTruth) {
  const auto source = open("good");
  EXPECT_TRUE(source->is_replay());
  EXPECT_TRUE(source->waits_for_arrival());
  EXPECT_EQ(source->size(), 6U);
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
    EXPECT_EQ(pair.sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(pair.status, PairStatus::kOk);
    EXPECT_EQ(pair.utime_us(), fake_simulator::exposure_us(i));
    EXPECT_EQ(pair.skew(), std::chrono::microseconds(fake_simulator::kSkew_us));
    EXPECT_EQ(pair.calibration, fake_simulator::calibration());
    EXPECT_EQ(pair.left.row(15)[20], i);
    EXPECT_EQ(pair.right.row(15)[20], 100 + i);
    ASSERT_EQ(pair.enclosed.size(), 2U);
    EXPECT_EQ(pair.enclosed[0].channel, "SIM_TRUTH_POSE");
    EXPECT_EQ(pair.enclosed[1].channel, "SIM_TRUTH_OBJECTS");
    EXPECT_EQ(decoded<truth_pose_t>(pair.enclosed[0]).sequence, i);
    EXPECT_EQ(decoded<truth_object_list_t>(pair.enclosed[1]).utime, pair.utime_us());
  }
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
}

TEST(SimSource, HandsOutTheWheelsOfADrivenRigAndLeavesTheBusToTheSimulator) {
  const auto source = open("has-wheels");
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
    ASSERT_TRUE(pair.wheels);
    EXPECT_EQ(pair.wheels->T_wheels_body.translation().x(), fake_simulator::kWheelStep_m * i);
    ASSERT_EQ(pair.enclosed.size(), 3U);
    EXPECT_EQ(pair.enclosed[2].channel, "PIONEER_ODOMETRY");
    EXPECT_EQ(decoded<odometry_t>(pair.enclosed[2]).utime, pair.utime_us());
    EXPECT_FALSE(pair.enclosed[2].is_for_bus);
  }
}

TEST(SimSource, HasNoWheelsWhereTheRigIsNotDriven) {
  const auto source = open("good");
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_FALSE(pair.wheels);
}

TEST(SimSource, TakesNoMemoryInItsSteadyState) {
  const auto source = open("good");
  const std::stop_source stop;
  StereoPair pair;
  for (int i = 0; i < 2; ++i) ASSERT_EQ(source->next(pair, stop.get_token()), SourceState::kPair);
  const long before = allocations();
  for (int i = 2; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, stop.get_token()), SourceState::kPair);
  }
  EXPECT_EQ(allocations() - before, 0);
}

TEST(SimSource, RejectsALeftImageWithoutARightOne) {
  const auto source = open("winks");
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
    EXPECT_EQ(pair.status, i == 2 ? PairStatus::kRejected : PairStatus::kOk) << i;
    EXPECT_EQ(pair.enclosed.size(), 2U);
  }
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
}

TEST(SimSource, CountsALeftImageThatNeverCame) {
  const auto source = open("blinks");
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs - 1; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
    EXPECT_EQ(pair.status, PairStatus::kOk);
    EXPECT_EQ(pair.utime_us(), fake_simulator::exposure_us(i < 2 ? i : i + 1));
  }
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
  EXPECT_EQ(source->counters().lost_images, 1U);
  EXPECT_EQ(source->counters().dropped_images, 0U);
}

TEST(SimSource, TellsWhatTheSimulatorHadNoTimeForFromWhatGotLost) {
  const auto source = open("hurries");
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
    EXPECT_EQ(pair.sequence, static_cast<std::uint64_t>(i < 2 ? i : i + 3));
    EXPECT_EQ(pair.utime_us(), fake_simulator::exposure_us(i < 2 ? i : i + 3));
  }
  EXPECT_EQ(source->counters().dropped_images, 3U);
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
  EXPECT_EQ(source->counters().dropped_images, 5U) << "the last ones count too";
  EXPECT_EQ(source->counters().lost_images, 0U);
}

TEST(SimSource, KeepsTheLimitOfSkewAndTheRate) {
  StereoPair pair;
  const auto strict = open("good", {.max_skew_s = 0.001});
  ASSERT_EQ(strict->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.status, PairStatus::kRejected);
  const auto slow = open("good", {.max_rate_hz = 15.0});
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(slow->next(pair, {}), SourceState::kPair);
    EXPECT_EQ(pair.status, i % 2 == 0 ? PairStatus::kOk : PairStatus::kSkipped);
  }
}

TEST(SimSource, TakesACalibrationThatFitsItsImages) {
  const auto source = open("good");
  Calibration other = fake_simulator::calibration();
  other.camera.baseline_m = 0.4;
  source->set_calibration(other);
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.calibration.camera.baseline_m, 0.4);
  other.left.width_px += 1;
  EXPECT_THROW(source->set_calibration(other), SourceError);
}

TEST(SimSource, PrefersARigFileThatFitsItsImages) {
  const std::string file = ::testing::TempDir() + "/sim_rig_" + std::to_string(getpid()) + ".toml";
  const auto open_with_rig = [&](const std::string& size) {
    const std::string camera = "size_px = " + size +
                               "\nfx_px = 36.0\nfy_px = 36.0\ncx_px = 19.5\ncy_px = 14.5\n"
                               "distortion = [0.03, 0.0, 0.0, 0.0, 0.0]\n";
    std::ofstream(file) << "[left]\n"
                        << camera << "[right]\n"
                        << camera << "[right_from_left]\n"
                        << "rotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n"
                        << "translation_m = [-0.5, 0.0, 0.0]\n";
    return open_sim_source({.program = FAKE_SIMULATOR, .world = "good", .rig_file = file}, {});
  };
  StereoPair pair;
  ASSERT_EQ(open_with_rig("[40, 30]")->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.calibration.left.distortion[0], 0.03);
  EXPECT_NEAR(pair.calibration.camera.baseline_m, 0.5, 1e-9);
  EXPECT_THROW(open_with_rig("[48, 30]"), SourceError);
  unlink(file.c_str());
}

TEST(SimSource, SaysWhatTheSimulatorSaidWhenItCouldNotBegin) {
  EXPECT_THAT(refusal("cannot-begin"),
              AllOf(HasSubstr("ended with exit code 1"), HasSubstr("nowhere: no such world")));
  EXPECT_THAT(refusal("greets-in-another-version"), HasSubstr("no greeting of version 2"));
  EXPECT_THAT(refusal("shares-nothing"), HasSubstr("memory that does not hold its images"));
}

TEST(SimSource, SaysWhyTheSimulatorEnded) {
  EXPECT_THAT(failure("dies"),
              HasSubstr("egomod-sim ended with exit code 3: egomod-sim: the lamp broke"));
  EXPECT_THAT(failure("is-killed"), HasSubstr("was ended by signal 9 (Killed)"));
  EXPECT_THAT(failure("hangs-up"), HasSubstr("had to be killed"));
}

TEST(SimSource, GetsAllThatASimulatorSentBeforeItLeft) {
  const auto source = open("leaves-in-a-hurry");
  StereoPair pair;
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
  }
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd) << source->error();
}

TEST(SimSource, DoesNotWaitForeverForASimulatorThatStalls) {
  EXPECT_THAT(failure("stalls", 1s), HasSubstr("egomod-sim has sent nothing for 1 s"));
}

TEST(SimSource, RefusesGarbage) {
  EXPECT_THAT(failure("unknown-kind"), HasSubstr("a packet of an unknown kind"));
  EXPECT_THAT(failure("short-packet"), HasSubstr("a packet of 12 bytes"));
  EXPECT_THAT(failure("other-size"), HasSubstr("an image that cannot be"));
  EXPECT_THAT(failure("wrong-slot"), HasSubstr("an image that cannot be"));
  EXPECT_THAT(failure("half-a-truth"), HasSubstr("truth that is not whole"));
  EXPECT_THAT(failure("counts-backwards"), HasSubstr("images numbered backwards"));
  EXPECT_THAT(failure("no-truth"), HasSubstr("something else as truth_pose_t"));
}

TEST(SimSource, PassesOnWhatTheSimulatorSaysAndIsNotHeldUpByIt) {
  const auto source = open("chatters");
  StereoPair pair;
  for (int i = 0; i < fake_simulator::kPairs; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair) << source->error();
  }
  EXPECT_EQ(source->notice(), "egomod-sim: no bus");
}

TEST(SimSource, StopsPromptlyWhileWaiting) {
  const auto source = open("stalls");
  StereoPair pair;
  for (int i = 0; i < 2; ++i) ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  std::stop_source stop;
  const auto start = std::chrono::steady_clock::now();
  std::jthread stopper([&] {
    std::this_thread::sleep_for(20ms);
    stop.request_stop();
  });
  EXPECT_EQ(source->next(pair, stop.get_token()), SourceState::kStopped);
  EXPECT_LT(std::chrono::steady_clock::now() - start, kPatience / 2);
}

TEST(SimSource, LeavesNoProcessBehind) {
  const std::string file = ::testing::TempDir() + "/fake_simulator_pid_" + std::to_string(getpid());
  open("stalls@" + file).reset();
  pid_t pid = 0;
  std::ifstream(file) >> pid;
  ASSERT_GT(pid, 0);
  EXPECT_EQ(kill(pid, 0), -1);
  unlink(file.c_str());
}

TEST(SimSource, NamesAProgramThatCannotBeStarted) {
  try {
    static_cast<void>(open_sim_source({.program = "/nowhere/egomod-sim"}, {}));
    FAIL();
  } catch (const SourceError& problem) {
    EXPECT_THAT(problem.what(), AllOf(HasSubstr("cannot be started"), HasSubstr("No such file")));
  }
}

}  // namespace
}  // namespace egomod
