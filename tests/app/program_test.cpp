// SPDX-License-Identifier: Apache-2.0
// Runs the real daemon: exit codes, messages, signals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "run_program.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kFailure = 1;
constexpr int kUsage = 2;
constexpr int kConfig = 78;
// Tests want no bus: a provider that does not leave the process.
const std::string kNoBus = "--lcm-url=memq://";

class Daemon : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(::testing::TempDir()) / ("egomod_program_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static pid_t start(std::vector<std::string> arguments, const fs::path& output) {
    arguments.insert(arguments.begin(), EGOMODD);
    return start_program(arguments, output);
  }
  static Outcome run(const std::vector<std::string>& arguments) {
    const fs::path output = folder_ / "output";
    return wait_for_program(start(arguments, output), output);
  }
  static std::string sequence() { return std::string("--source=folder:") + kSequence; }
  static fs::path copy_of_sequence(const std::string& name) {
    fs::copy(kSequence, folder_ / name, fs::copy_options::recursive);
    return folder_ / name;
  }

  static constexpr const char* kSequence = EGOMOD_TEST_SEQUENCES "/slow_320";
  static constexpr int kPairs = 12;
  static inline fs::path folder_;
};

TEST_F(Daemon, records_the_same_bytes_each_time_with_one_thread_and_with_five) {
  const auto record = [](const std::string& name) {
    return "--record=" + (folder_ / name).string();
  };
  ASSERT_EQ(run({sequence(), kNoBus, record("five")}).exit_code, 0);
  ASSERT_EQ(run({sequence(), kNoBus, record("again")}).exit_code, 0);
  ASSERT_EQ(run({sequence(), kNoBus, record("one"), "--single-thread"}).exit_code, 0);
  const std::string five = read(folder_ / "five");
  EXPECT_GT(five.size(), 1000U * kPairs);
  EXPECT_EQ(five, read(folder_ / "again"));
  EXPECT_EQ(five, read(folder_ / "one"));
}

TEST_F(Daemon, ends_a_replay_with_a_summary_and_0) {
  const Outcome outcome = run({sequence(), kNoBus});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("pairs           12 of 1.10 s"));
  EXPECT_THAT(outcome.output, HasSubstr("egomotion"));
  EXPECT_THAT(outcome.output, HasSubstr("path"));
}

TEST_F(Daemon, is_silent_when_quiet) {
  const Outcome outcome = run({sequence(), kNoBus, "--quiet"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.output, "");
}

TEST_F(Daemon, warns_once_without_a_bus_and_records_the_same) {
  const std::string with = (folder_ / "with").string();
  const std::string without = (folder_ / "without").string();
  ASSERT_EQ(run({sequence(), kNoBus, "--record", with}).exit_code, 0);
  const Outcome outcome = run({sequence(), "--lcm-url=nothing://", "--record", without});
  EXPECT_EQ(outcome.exit_code, 0);
  const std::size_t first = outcome.output.find("warning");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(outcome.output.find("warning", first + 1), std::string::npos) << outcome.output;
  EXPECT_EQ(read(with), read(without));
}

TEST_F(Daemon, refuses_a_missing_folder) {
  const Outcome outcome = run({"--source=folder:/nowhere/at/all", kNoBus});
  EXPECT_EQ(outcome.exit_code, kFailure);
  EXPECT_THAT(outcome.output, HasSubstr("/nowhere/at/all"));
}

TEST_F(Daemon, refuses_an_unknown_source) {
  for (const char* source : {"telepathy", "folder", "folder:", "lcm:there"}) {
    const Outcome outcome = run({std::string("--source=") + source, kNoBus});
    EXPECT_EQ(outcome.exit_code, kConfig);
    EXPECT_THAT(outcome.output, HasSubstr(std::string("--source: daemon.source: source '") +
                                          source + "' is unknown or not built in"));
  }
}

TEST_F(Daemon, checks_source_and_rig_with_the_configuration) {
  const std::string bad_rig = (folder_ / "bad_rig.toml").string();
  std::ofstream(bad_rig) << "[rectified]\nsize_px = [40]\n";
  for (const char* more : {"--check-config", "--quiet"}) {
    EXPECT_EQ(run({"--source=telepathy", more}).exit_code, kConfig);
    EXPECT_EQ(run({sequence(), "--rig=/nowhere.toml", more}).exit_code, kConfig);
    const Outcome outcome = run({sequence(), "--rig", bad_rig, more});
    EXPECT_EQ(outcome.exit_code, kConfig);
    EXPECT_THAT(outcome.output, HasSubstr("--rig: daemon.rig: " + bad_rig + ":2: "));
  }
  EXPECT_EQ(run({sequence(), "--check-config"}).exit_code, 0);
}

TEST_F(Daemon, fails_when_standard_output_takes_nothing) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--dump-config"}, {sequence(), kNoBus}}) {
    EXPECT_EQ(wait_for_program(start(arguments, "/dev/full"), "/dev/null").exit_code, kFailure);
  }
}

TEST_F(Daemon, says_with_one_thread_as_with_five_what_of_the_scheduling_is_not_to_be_had) {
  for (const char* threads : {"--set=pipeline.single_thread=false", "--single-thread"}) {
    const Outcome outcome = run({sequence(), kNoBus, threads, "--set=pipeline.cpus=1023"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.output, HasSubstr("is not bound to CPU 1023")) << threads;
  }
}

TEST_F(Daemon, records_of_a_paced_replay_nothing_that_the_clock_decides) {
  const fs::path record = folder_ / "paced";
  const std::string path = record.string();
  ASSERT_EQ(run({sequence(), kNoBus, "--realtime", "--record", path}).exit_code, 0);
  EXPECT_EQ(read(record).find("EGOMOD_TIMING"), std::string::npos);
  const std::string calibration = "EGOMOD_CALIBRATION";
  const std::string bytes = read(record);
  EXPECT_EQ(bytes.find(calibration), bytes.rfind(calibration)) << "the calibration came again";
  ASSERT_EQ(run({sequence(), kNoBus, "--realtime", "--record", path, "--record-timing"}).exit_code,
            0);
  EXPECT_NE(read(record).find("EGOMOD_TIMING"), std::string::npos);
}

// liblcm complains on stderr each time that it is asked for a provider that it does not have.
TEST_F(Daemon, asks_for_an_absent_bus_ever_less_often_and_warns_once) {
  const fs::path output = folder_ / "no_bus_output";
  const pid_t pid = start({"--source=lcm", "--lcm-url=nothing://"}, output);
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  kill(pid, SIGTERM);
  const std::string said = wait_for_program(pid, output).output;
  const auto count = [&](const std::string& text) {
    int times = 0;
    for (auto at = said.find(text); at != std::string::npos; at = said.find(text, at + 1)) ++times;
    return times;
  };
  EXPECT_LE(count("Error: LCM provider"), 3) << said;
  EXPECT_EQ(count("cannot be opened"), 1) << said;
}

TEST_F(Daemon, refuses_a_record_that_cannot_be_written_before_it_starts) {
  const Outcome outcome = run({sequence(), kNoBus, "--record=/nowhere/record"});
  EXPECT_EQ(outcome.exit_code, kFailure);
  EXPECT_THAT(outcome.output, HasSubstr("/nowhere/record"));
  EXPECT_EQ(outcome.output.find("pairs"), std::string::npos) << outcome.output;
}

TEST_F(Daemon, processes_and_records_what_comes_before_an_unreadable_image) {
  const fs::path broken = copy_of_sequence("broken");
  std::ofstream(broken / "image_0" / "000007.png") << "not an image";
  const std::string record = (folder_ / "broken_record").string();
  const std::string whole = (folder_ / "whole_record").string();
  ASSERT_EQ(run({sequence(), kNoBus, "--record", whole}).exit_code, 0);
  const Outcome outcome = run({"--source=folder:" + broken.string(), kNoBus, "--record", record});
  EXPECT_EQ(outcome.exit_code, kFailure);
  EXPECT_THAT(outcome.output, HasSubstr("000007.png"));
  EXPECT_THAT(outcome.output, HasSubstr("7 pairs before it were processed"));
  const std::string bytes = read(record);
  EXPECT_GT(bytes.size(), 5000U);
  EXPECT_EQ(bytes, read(whole).substr(0, bytes.size()));
}

TEST_F(Daemon, refuses_a_bad_configuration_with_file_line_and_key) {
  const std::string file = (folder_ / "bad.toml").string();
  std::ofstream(file) << "[pipeline]\n\nslot = 8\n";
  for (const char* action : {"--check-config", "--dump-config", "--quiet"}) {
    const Outcome outcome = run({"--config", file, action, sequence()});
    EXPECT_EQ(outcome.exit_code, kConfig);
    EXPECT_THAT(outcome.output, HasSubstr(file + ":3:1: pipeline.slot: unknown key"));
  }
}

TEST_F(Daemon, accepts_what_it_dumps) {
  const Outcome dumped = run({"--preset=thesis", "--set=pipeline.slots=9", "--dump-config"});
  EXPECT_EQ(dumped.exit_code, 0);
  const std::string file = (folder_ / "dumped.toml").string();
  std::ofstream(file) << dumped.output;
  EXPECT_EQ(run({"--config", file, "--check-config"}).exit_code, 0);
  EXPECT_EQ(run({"--config", file, "--dump-config"}).output, dumped.output);
}

TEST_F(Daemon, lets_the_command_line_win_over_the_file_and_the_file_over_the_preset) {
  const std::string file = (folder_ / "order.toml").string();
  std::ofstream(file) << "[capture]\nmax_rate_hz = 7.0\n[pipeline]\nslots = 8\n";
  const std::string dump =
      run({"--set=pipeline.slots=9", "--config", file, "--preset=thesis", "--dump-config"}).output;
  EXPECT_THAT(dump, HasSubstr("max_rate_hz = 7.0\n"));
  EXPECT_THAT(dump, HasSubstr("slots = 9\n"));
  EXPECT_THAT(dump, HasSubstr("method = \"thesis\"\n"));
}

TEST_F(Daemon, refuses_an_unknown_preset_and_lists_those_there_are) {
  const Outcome outcome = run({"--preset=thesys", sequence()});
  EXPECT_EQ(outcome.exit_code, kConfig);
  EXPECT_THAT(outcome.output, HasSubstr("there are: thesis"));
}

TEST_F(Daemon, refuses_an_unknown_option_and_a_missing_source) {
  EXPECT_EQ(run({"--fast"}).exit_code, kUsage);
  EXPECT_EQ(run({}).exit_code, kConfig);
}

TEST_F(Daemon, says_its_version_and_what_is_built_in) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("sources: "));
}

// The sequence is paced, so that the signal always meets a running daemon.
TEST_F(Daemon, stops_with_0_when_asked_to) {
  for (const int signal : {SIGTERM, SIGINT}) {
    for (const char* threads : {"--set=pipeline.single_thread=false", "--single-thread"}) {
      const fs::path slow = folder_ / "slow";
      if (!fs::exists(slow)) {
        std::ofstream times(copy_of_sequence("slow") / "times.txt");
        for (int i = 0; i < kPairs; ++i) {
          times << 100 * i << ".0\n";
        }
      }
      const fs::path output = folder_ / "stop_output";
      const pid_t pid =
          start({"--source=folder:" + slow.string(), "--realtime", kNoBus, threads}, output);
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      kill(pid, signal);
      const Outcome outcome = wait_for_program(pid, output);
      EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
      EXPECT_THAT(outcome.output, HasSubstr("stopping"));
    }
  }
}

}  // namespace
}  // namespace egomod
