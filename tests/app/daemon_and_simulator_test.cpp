// SPDX-License-Identifier: Apache-2.0
// The real daemon with a fake of egomod-sim: where it looks for it, and what it says and does when
// it is not there or breaks down.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "run_program.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A copy of the daemon in a tree of its own, so that the built egomod-sim is not beside it.
class DaemonAndSimulator : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root_ / "bin");
    fs::copy_file(EGOMODD, root_ / "bin" / "egomodd");
  }
  void TearDown() override { fs::remove_all(root_); }

  void install_simulator(const fs::path& folder) {
    fs::create_directories(root_ / folder);
    fs::copy_file(FAKE_SIMULATOR, root_ / folder / "egomod-sim");
  }
  Outcome run(const std::string& source, const std::vector<std::string>& more = {}) {
    std::vector<std::string> command{"/usr/bin/env", "PATH=" + (root_ / "path").string(),
                                     (root_ / "bin" / "egomodd").string(), "--lcm-url=memq://",
                                     "--source=" + source};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command, root_ / "output");
  }

  const fs::path root_ =
      fs::path(::testing::TempDir()) / ("egomod_simulator_test_" + std::to_string(getpid()));
};

TEST_F(DaemonAndSimulator, NamesThePackageOfASimulatorThatIsNowhere) {
  const Outcome outcome = run("sim");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output,
              AllOf(HasSubstr("there is no program egomod-sim in " + (root_ / "bin").string()),
                    HasSubstr("install the package egomod-sim"), HasSubstr("libegl-dev")));
}

TEST_F(DaemonAndSimulator, FindsItBesideItselfInLibexecAndInThePath) {
  for (const char* folder : {"bin", "libexec/egomod", "path"}) {
    install_simulator(folder);
    const Outcome outcome = run("sim:good");
    EXPECT_EQ(outcome.exit_code, 0) << folder << ": " << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("pairs           6 of "));
    fs::remove(root_ / folder / "egomod-sim");
  }
}

TEST_F(DaemonAndSimulator, FailsWithTheLastWordsOfASimulatorThatDies) {
  install_simulator("bin");
  const Outcome outcome = run("sim:dies", {"--record", root_ / "record"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output,
              HasSubstr("egomod-sim ended with exit code 3: egomod-sim: the lamp broke; "
                        "2 pairs before it were processed"));
  EXPECT_GT(fs::file_size(root_ / "record"), 1000U);
}

TEST_F(DaemonAndSimulator, RefusesAWorldThatTheSimulatorRefuses) {
  install_simulator("bin");
  const Outcome outcome = run("sim:cannot-begin");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("egomod-sim: nowhere: no such world"));
}

}  // namespace
}  // namespace egomod
