// SPDX-License-Identifier: Apache-2.0
#include "world_file.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGood =
    "duration_s = 1.0\n[camera]\n[shell]\nkind = \"room\"\nwidth_m = 6.0\nlength_m = 8.0\n"
    "[rig]\nmotion = { kind = \"still\", position_m = [0.0, 0.0] }\n";

std::string complaint(const std::string& text) {
  const fs::path file = fs::path(testing::TempDir()) / "egomod_world.toml";
  std::ofstream(file) << text;
  try {
    (void)read_world(file);
  } catch (const WorldError& error) {
    return error.what();
  }
  return "none";
}

std::string with_object(const std::string& lines) {
  return kGood + std::string("[[object]]\n") + lines;
}

TEST(WorldFile, EveryShippedWorldCanBeRead) {
  const auto names = worlds_in(EGOMOD_WORLDS_DIR);
  EXPECT_GE(names.size(), 12U);
  for (const std::string& name : names) {
    EXPECT_NO_THROW((void)read_world(find_world(name, EGOMOD_WORLDS_DIR))) << name;
  }
}

TEST(WorldFile, NamesFileLineAndKeyOfWhatItRefuses) {
  EXPECT_EQ(complaint(kGood), "none");
  EXPECT_THAT(complaint(std::string("speed = 1\n") + kGood),
              testing::HasSubstr("egomod_world.toml:1: speed: there is no such key"));
  EXPECT_THAT(complaint(with_object("kind = \"pioneer\"\nmotion = { kind = \"still\", position_m = "
                                    "[9.0, 1.0] }\n")),
              testing::HasSubstr("outside the world"));
  EXPECT_THAT(complaint(with_object("kind = \"box\"\nsize_m = [0.0, 1.0, 1.0]\n")),
              testing::HasSubstr(":11: object[1].size_m: 0 is outside"));
  EXPECT_THAT(complaint(with_object("kind = \"pioneer\"\nmotion = { kind = \"still\", position_m = "
                                    "[nan, 1.0] }\n")),
              testing::HasSubstr("position_m: must be finite"));
}

}  // namespace
}  // namespace egomod::sim
