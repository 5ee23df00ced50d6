// SPDX-License-Identifier: Apache-2.0
// tools/evaluate-worlds from rendering to the table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kWorld = R"(duration_s = 3.0
seed = 3
[camera]
width_px = 160
height_px = 120
baseline_m = 0.2
rate_hz = 5.0
[shell]
kind = "room"
width_m = 5.0
length_m = 9.0
[rig]
motion = { kind = "line", position_m = [0.0, 0.0], speed_mps = 0.3 }
[[object]]
kind = "pioneer"
motion = { kind = "line", position_m = [-1.0, 3.0], heading_deg = 90.0, speed_mps = 0.5 }
)";

// One that cannot be does not spoil the other, but the exit code tells.
TEST(EvaluateWorlds, MakesOneTableAndNamesTheWorldThatIsLeftOut) {
  const eval::TemporaryFolder folder;
  const auto in = [&](const std::string& name) { return folder.path() + "/" + name; };
  std::ofstream(in("tiny.toml")) << kWorld;
  std::ofstream(in("broken.toml")) << "duration_s = 1.0\nshel = 3\n";
  const std::string programs = EGOMOD_PROGRAMS;
  const Outcome outcome =
      run_program({programs + "/evaluate-worlds", "--programs", programs, "--output", in("out"),
                   "--table", in("results.md"), "--worlds", in("tiny.toml"), in("broken.toml")},
                  in("printed"));
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("[2/2] broken"));
  const std::string table = read(in("results.md"));
  EXPECT_THAT(table, HasSubstr("| tiny | default | 3 |"));
  EXPECT_THAT(table, HasSubstr("| tiny | thesis | 3 |"));
  EXPECT_THAT(table, HasSubstr("| mean | thesis |"));
  EXPECT_THAT(table, HasSubstr("Left out: broken: egomod-sim: " + in("broken.toml") + ":"));
  const std::string figures = read(in("out/figures.json"));
  EXPECT_THAT(figures, HasSubstr("\"method\": \"thesis\""));
  EXPECT_THAT(figures, HasSubstr("\"speed_radar\": {\"all\": {\"n\": "));
  EXPECT_THAT(figures, Not(HasSubstr("\"sigma_m_s\": null"))) << "the record's standard errors";
  EXPECT_FALSE(fs::exists(in("out/tiny/truth/image_0")));
}

// Nothing of the user's is lost in the output folder, whatever a world is called.
TEST(EvaluateWorlds, RefusesNamesThatAreNoneOrTwiceAndRemovesNothing) {
  const eval::TemporaryFolder folder;
  const auto in = [&](const std::string& name) { return folder.path() + "/" + name; };
  for (const char* name : {"out", "one", "two"}) fs::create_directories(in(name));
  for (const char* name : {"out/precious", "out/bare", "one/tiny.toml", "two/tiny.toml"})
    std::ofstream(in(name)) << kWorld;
  const std::string programs = EGOMOD_PROGRAMS;
  const auto evaluate = [&](const std::vector<std::string>& worlds) {
    std::vector<std::string> command{
        programs + "/evaluate-worlds", "--programs", programs, "--output", in("out"), "--worlds"};
    command.insert(command.end(), worlds.begin(), worlds.end());
    return run_program(command, in("printed"));
  };
  for (const char* name : {"", "/", ".", ".."}) {
    const Outcome outcome = evaluate({name});
    EXPECT_EQ(outcome.exit_code, 2) << name;
    EXPECT_THAT(outcome.output, HasSubstr("names no world")) << name;
  }
  const Outcome twice = evaluate({in("one/tiny.toml"), in("two/tiny.toml")});
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.output, HasSubstr("two worlds are called tiny"));
  const Outcome in_its_way = evaluate({in("out/bare")});
  EXPECT_EQ(in_its_way.exit_code, 1);
  EXPECT_THAT(in_its_way.output, HasSubstr(in("out/bare") + ": cannot be made a folder"));
  EXPECT_EQ(read(in("out/precious")), kWorld);
  EXPECT_EQ(read(in("out/bare")), kWorld);
}

}  // namespace
}  // namespace egomod
