// SPDX-License-Identifier: Apache-2.0
// The scripts that measure fail where there is nothing to measure, and say why. Programs are stood
// in for by shell scripts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_program.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWrongUsage = 2;
constexpr const char* kFigures = "corridor\n  NEES 1 s   0.90\n";

class Scripts : public ::testing::Test {
 protected:
  Scripts() {
    fs::create_directories(programs_);
    for (const char* name : {"egomodd", "egomod-sim", "egomod-eval"}) stand_in(name, "exit 0");
  }
  ~Scripts() override { fs::remove_all(root_); }

  void stand_in(const std::string& name, const std::string& does) {
    std::ofstream(programs_ / name) << "#!/bin/sh\n" << does << '\n';
    fs::permissions(programs_ / name, fs::perms::owner_all);
  }
  // An egomod-eval that finds these figures, and an egomodd that leaves a record.
  void succeed_with(const std::string& figures) {
    stand_in("egomodd", "while [ $# -gt 0 ]; do [ $1 != --record ] || : >$2; shift; done");
    stand_in("egomod-eval", "printf '" + figures + "'");
  }
  Outcome run(std::vector<std::string> arguments) {
    arguments.front() = EGOMOD_PROGRAMS "/" + arguments.front();
    arguments.insert(arguments.begin(), {"/usr/bin/env", "EGOMOD_BIN=" + programs_.string()});
    return run_program(arguments, root_ / "printed");
  }
  Outcome honesty(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"measure-honesty", "--output", out_});
    return run(std::move(arguments));
  }

  fs::path root_ = fs::path(::testing::TempDir()) / ("egomod_scripts_" + std::to_string(getpid()));
  fs::path programs_ = root_ / "bin";
  std::string out_ = root_ / "out";
};

TEST_F(Scripts, that_are_called_wrongly_exit_with_2) {
  const std::vector<std::vector<std::string>> commands{
      {"measure-honesty"},
      {"measure-honesty", "--output"},
      {"measure-honesty", "--output", out_},
      {"measure-honesty", "--output", out_, "--seeds", "0", "corridor"},
      {"measure-honesty", "--output", out_, "--seeds", "many", "corridor"},
      {"measure-honesty", "--output", out_, "--seconds", "1.9", "corridor"},
      {"measure-honesty", "--output", out_, "--first-seed", "-1", "corridor"},
      {"measure-honesty", "--output", out_, "--no-such-option", "corridor"},
      {"compare-egomotion", "--output", out_, "--seconds"},
      {"compare-egomotion", "--output", out_, "--seconds", "0", "corridor"},
      {"compare-egomotion", "--output", out_}};
  for (const auto& command : commands) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, kWrongUsage) << ::testing::PrintToString(command);
    EXPECT_THAT(outcome.output, HasSubstr("usage: ")) << ::testing::PrintToString(command);
  }
}

TEST_F(Scripts, in_python_that_are_called_wrongly_exit_with_2) {
  const std::vector<std::vector<std::string>> commands{
      {"measure-accuracy", "--samples", "0"},
      {"measure-accuracy", "--speed", "0"},
      {"measure-accuracy", "--speed", "nan"},
      {"measure-accuracy", "--depths", "-1"},
      {"measure-accuracy", "--rigs", "30x0"},
      {"measure-speed-limits", "--samples", "0"},
      {"measure-speed-limits", "--rig-speed", "-1"},
      {"measure-movers", "--seeds", "0"},
      {"measure-movers", "--shares", "0.9"},
      {"measure-movers", "--kinds", "jumps"},
      {"random-worlds", "--output", out_, "--count", "0"},
      {"random-worlds", "--output", out_, "--first-seed", "-5"},
      {"random-worlds"}};
  for (const auto& command : commands) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, kWrongUsage) << ::testing::PrintToString(command);
    EXPECT_THAT(outcome.output, HasSubstr("usage: ")) << ::testing::PrintToString(command);
  }
  for (const char* script : {"measure-accuracy", "measure-movers", "measure-speed-limits"}) {
    const Outcome outcome = run({script, "--programs", "/nonexistent"});
    EXPECT_EQ(outcome.exit_code, 1) << script;
    EXPECT_THAT(outcome.output, HasSubstr("/nonexistent/egomodd: is no program")) << script;
    EXPECT_THAT(outcome.output, Not(HasSubstr("Traceback"))) << script;
  }
}

class RandomWorlds : public Scripts {
 protected:
  Outcome draw(const std::string& first_seed, const std::string& count) {
    return run({"random-worlds", "--output", out_, "--programs", programs_, "--count", count,
                "--first-seed", first_seed});
  }
  [[nodiscard]] std::string world(int seed) const {
    std::stringstream text;
    text << std::ifstream(fs::path(out_) / ("random-" + std::to_string(seed) + ".toml")).rdbuf();
    return text.str();
  }
};

TEST_F(RandomWorlds, are_the_same_for_the_same_seed) {
  stand_in("egomod-sim", "exit 0");
  EXPECT_EQ(draw("7", "2").exit_code, 0);
  const std::string first = world(7);
  EXPECT_THAT(first, HasSubstr("seed = 7\n"));
  EXPECT_THAT(first, HasSubstr("[rig]"));
  EXPECT_NE(world(8), first);
  fs::remove_all(out_);
  EXPECT_EQ(draw("7", "1").exit_code, 0);
  EXPECT_EQ(world(7), first);
}

TEST_F(RandomWorlds, are_drawn_anew_where_the_renderer_refuses_them) {
  stand_in("egomod-sim", "exit 0");
  EXPECT_EQ(draw("7", "1").exit_code, 0);
  const std::string first = world(7);
  const std::string tried = (root_ / "tried").string();
  stand_in("egomod-sim", "[ -e " + tried + " ] || { touch " + tried + "; exit 1; }");
  EXPECT_EQ(draw("7", "1").exit_code, 0);
  EXPECT_NE(world(7), first);
  EXPECT_THAT(world(7), HasSubstr("seed = 7\n"));
}

TEST_F(RandomWorlds, say_why_none_can_be_rendered_and_leave_none) {
  EXPECT_EQ(run({"random-worlds", "--output", out_, "--programs", "/nonexistent"}).exit_code, 1);
  EXPECT_THAT(run({"random-worlds", "--output", out_, "--programs", "/nonexistent"}).output,
              HasSubstr("/nonexistent/egomod-sim: is no program"));
  stand_in("egomod-sim", "echo it runs into a wall >&2; exit 1");
  const Outcome refused = draw("1", "1");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("no world of seed 1 can be rendered"));
  EXPECT_THAT(refused.output, HasSubstr("it runs into a wall"));
  EXPECT_FALSE(fs::exists(fs::path(out_) / "random-1.toml"));
  stand_in("egomod-sim", "kill -SEGV $$");
  const Outcome died = draw("1", "1");
  EXPECT_EQ(died.exit_code, 1);
  EXPECT_THAT(died.output, HasSubstr("egomod-sim: died of signal 11"));
}

TEST_F(Scripts, measure_honesty_prints_a_row_a_world_and_repeats_no_run) {
  succeed_with(kFigures);
  const Outcome outcome = honesty({"--seeds", "2", "corridor"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("| corridor | 2 | 0.90 | 0.00 | 1.00 |"));
  stand_in("egomodd", "exit 1");
  EXPECT_EQ(honesty({"--seeds", "2", "corridor"}).exit_code, 0);
}

TEST_F(Scripts, measure_honesty_has_no_figure_where_nothing_was_scored) {
  succeed_with("corridor\n  NEES 1 s   -\n");
  EXPECT_THAT(honesty({"--seeds", "1", "corridor"}).output,
              HasSubstr("| corridor | 0 | – | – | – |"));
}

TEST_F(Scripts, measure_honesty_fails_where_a_program_does_or_says_nothing) {
  for (const bool eval_fails : {false, true}) {
    succeed_with("");
    stand_in(eval_fails ? "egomod-eval" : "egomodd", "echo the disk is full >&2; exit 1");
    const Outcome outcome = honesty({"--seeds", "1", "corridor"});
    EXPECT_EQ(outcome.exit_code, 1) << eval_fails;
    EXPECT_THAT(outcome.output, HasSubstr("the disk is full")) << eval_fails;
    EXPECT_THAT(outcome.output, Not(HasSubstr("| corridor |"))) << eval_fails;
  }
  succeed_with("");
  EXPECT_EQ(honesty({"--seeds", "1", "corridor"}).exit_code, 1) << "without a figure";
  EXPECT_FALSE(fs::exists(out_ + "/corridor-901-4.txt")) << "it would pass for done";
}

TEST_F(Scripts, measure_honesty_names_a_world_that_is_none) {
  succeed_with(kFigures);
  const Outcome outcome = honesty({"corridor", "no-such-world"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("no-such-world: neither a world of"));
}

TEST_F(Scripts, compare_egomotion_shows_why_a_program_failed) {
  fs::create_directories(root_ / "no-images");
  stand_in("egomodd", "echo holds neither image_0 nor mav0/cam0; exit 1");
  const Outcome outcome =
      run({"compare-egomotion", "--output", out_, (root_ / "no-images").string()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("holds neither image_0 nor mav0/cam0"));
  EXPECT_THAT(outcome.output, HasSubstr("egomodd failed"));
}

}  // namespace
}  // namespace egomod
