// SPDX-License-Identifier: Apache-2.0
// Runs egomod-thesis and the two scripts: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "case_fixture.hpp"
#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace egomod::thesis {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kFailure = 1;
constexpr int kUsage = 2;

class Program : public ::testing::Test {
 protected:
  [[nodiscard]] std::string in(const std::string& name) const {
    return folder_.path() + "/" + name;
  }
  [[nodiscard]] Outcome run(const std::vector<std::string>& command) const {
    return run_program(command, in("printed"));
  }
  [[nodiscard]] std::vector<std::string> thesis(const std::vector<std::string>& more) const {
    std::vector<std::string> command{EGOMOD_THESIS, "--still",    in("still"),
                                     "--moving",    in("moving"), "--range",
                                     in("range"),   "--near",     in("range")};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  void write_cases() const {
    for (const char* name : {"still", "moving", "range"}) write_case(in(name));
  }
  static std::string script(const char* name) { return std::string(EGOMOD_PROGRAMS) + "/" + name; }

  eval::TemporaryFolder folder_;
};

TEST_F(Program, DrawsOnePageAndASummaryWithItsPictures) {
  write_cases();
  const Outcome outcome = run(thesis(
      {"--output", in("report.html"), "--summary", in("docs.md"), "--pictures", in("pictures")}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("0.866 to 13.537 m     5.500 to 6.500 m"));
  const std::string html = read(in("report.html"));
  for (int figure = 5; figure <= 11; ++figure)
    EXPECT_THAT(html, HasSubstr("Figure " + std::to_string(figure) + ":"));
  EXPECT_THAT(html, Not(HasSubstr("<img")));  // self-contained
  const std::string summary = read(in("docs.md"));
  EXPECT_THAT(summary, HasSubstr("](pictures/figure-05.svg)"));
  EXPECT_THAT(summary, HasSubstr("0.2385 m/s"));
  EXPECT_GT(fs::file_size(in("pictures/figure-11.svg")), 1000U);
}

TEST_F(Program, SaysWhichRecordIsMissingAndHowItIsMade) {
  write_cases();
  fs::remove(in("moving/thesis.lcmlog"));
  const Outcome outcome = run(thesis({"--output", in("report.html")}));
  EXPECT_EQ(outcome.exit_code, kFailure);
  EXPECT_THAT(outcome.output, HasSubstr("moving/thesis.lcmlog: is not there; "
                                        "tools/reproduce-thesis renders the cases"));
  EXPECT_FALSE(fs::exists(in("report.html")));
}

TEST_F(Program, SaysThatTheReportCannotBeWritten) {
  write_cases();
  const Outcome outcome = run(thesis({"--output", in("nowhere/report.html")}));
  EXPECT_EQ(outcome.exit_code, kFailure);
  EXPECT_THAT(outcome.output, HasSubstr("nowhere/report.html: cannot be written"));
}

TEST_F(Program, EndsWithTwoWhereTheCommandLineIsWrong) {
  EXPECT_EQ(run({EGOMOD_THESIS, "--still", "x"}).exit_code, kUsage);
  EXPECT_EQ(run({EGOMOD_EVAL, "--pairs", "some"}).exit_code, kUsage);
  EXPECT_EQ(run({EGOMOD_EVAL, "--record", "a", "--record", "b", "--method", "x"}).exit_code,
            kUsage);
  for (const std::string& name : {script("evaluate-worlds"), script("reproduce-thesis")}) {
    EXPECT_EQ(run({name, "--nonsense"}).exit_code, kUsage);
    EXPECT_EQ(run({name, "--output"}).exit_code, kUsage);
    EXPECT_EQ(run({name, "--duration", "-3"}).exit_code, kUsage);
    EXPECT_THAT(run({name, "--nonsense"}).output, HasSubstr("usage: "));
    EXPECT_EQ(run({name, "--help"}).exit_code, 0);
  }
  EXPECT_EQ(run({script("evaluate-worlds"), "--seed", "x"}).exit_code, kUsage);
  EXPECT_EQ(run({script("evaluate-worlds"), "--worlds"}).exit_code, kUsage);
}

TEST_F(Program, ScriptsSayWhatCannotBeWrittenOrIsNoProgram) {
  std::ofstream(in("file")) << "in the way";
  for (const std::string& name : {script("evaluate-worlds"), script("reproduce-thesis")}) {
    const Outcome blocked = run({name, "--programs", EGOMOD_PROGRAMS, "--output", in("file/x")});
    EXPECT_EQ(blocked.exit_code, kFailure);
    EXPECT_THAT(blocked.output, HasSubstr("cannot be written; give another folder with --output"));
    const Outcome empty = run({name, "--programs", folder_.path(), "--output", in("out")});
    EXPECT_EQ(empty.exit_code, kFailure);
    EXPECT_THAT(empty.output, HasSubstr("egomodd: is no program"));
  }
}

}  // namespace
}  // namespace egomod::thesis
