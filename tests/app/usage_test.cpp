// SPDX-License-Identifier: Apache-2.0
// Scripts tell a wrong command line from a run that failed, whichever program it is.
#include <gtest/gtest.h>

#include "run_program.hpp"

namespace egomod {
namespace {

constexpr int kUsage = 2;

Outcome run(std::vector<std::string> command) {
  command.front() = EGOMOD_PROGRAMS "/" + command.front();
  const auto output =
      std::filesystem::path(::testing::TempDir()) / ("egomod_usage_" + std::to_string(getpid()));
  Outcome outcome = run_program(command, output);
  std::filesystem::remove(output);
  return outcome;
}

TEST(Usage, that_is_wrong_exits_with_2) {
  const std::vector<std::vector<std::string>> commands{
      {"egomodd", "--no-such-option"},
      {"egomodd", "surplus"},
      {"egomod-log"},
      {"egomod-log", "no-such-command"},
      {"egomod-log", "info"},
      {"egomod-log", "import", "folder", "log", "--jpeg=101"},
      {"egomod-eval"},
      {"egomod-eval", "--no-such-option"},
      {"egomod-eval", "--every=0"},
      {"egomod-eval", "--record=record", "--v90=nan"},
      {"egomod-fit"},
      {"egomod-fit", "--no-such-option"},
      {"egomod-fit", "--record=record"},
      {"egomod-fit", "labels.csv", "--format=gif"},
      {"egomod-fit", "labels.csv", "--prior-moving=nan"},
      {"egomod-fit", "labels.csv", "--max-speed-mps=nan"},
      {"egomod-fit", "labels.csv", "--max-speed-mps=inf"},
      {"egomod-fit", "labels.csv", "--method=filter"},
      {"egomod-fit", "--record=record", "--method=filter", "--points=roles"},
      {"egomod-thesis"},
      {"egomod-thesis", "--no-such-option"},
#ifdef EGOMOD_HAS_SIM
      {"egomod-sim"},
      {"egomod-sim", "--no-such-option"},
      {"egomod-sim", "corridor"},
      {"egomod-sim", "corridor", "--duration=-1"},
      {"egomod-sim", "corridor", "--depth"},
#endif
  };
  for (const auto& command : commands) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, kUsage) << ::testing::PrintToString(command) << outcome.output;
    EXPECT_NE(outcome.output, "") << ::testing::PrintToString(command);
  }
}

TEST(Usage, that_asks_for_help_exits_with_0) {
  for (const char* program : {"egomodd", "egomod-log", "egomod-eval", "egomod-fit", "egomod-thesis",
#ifdef EGOMOD_HAS_SIM
                              "egomod-sim"
#endif
       }) {
    EXPECT_EQ(run({program, "--help"}).exit_code, 0) << program;
  }
}

}  // namespace
}  // namespace egomod
