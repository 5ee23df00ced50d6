// SPDX-License-Identifier: Apache-2.0
#include "drive_file.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "world_file.hpp"

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class DriveFile : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove(file_); }

  World world(const std::string& rig, const std::string& duration = "1.0") const {
    std::ofstream(file_) << "duration_s = " << duration
                         << "\n[camera]\n[shell]\nkind = \"room\"\nwidth_m = 6.0\nlength_m = 8.0\n"
                         << "[rig]\n"
                         << rig;
    return read_world(file_);
  }
  std::string complaint(const std::string& rig, const std::string& duration = "1.0") const {
    try {
      static_cast<void>(world(rig, duration));
    } catch (const WorldError& error) {
      return error.what();
    }
    return "none";
  }

  const fs::path file_ =
      fs::path(::testing::TempDir()) / ("egomod_drive_" + std::to_string(getpid()) + ".toml");
};

TEST_F(DriveFile, GivesTheBaseItsPlaceItsLimitsAndItsScript) {
  const World read = world(
      "[rig.driven]\nposition_m = [1.0, 2.0]\nheading_deg = 90.0\nmax_turn_degps = 45.0\n"
      "[[rig.driven.command]]\nat_s = 0.5\nspeed_mps = 0.4\nturn_degps = 90.0\n",
      "0");
  ASSERT_TRUE(read.rig.driven);
  EXPECT_TRUE(read.is_endless());
  const Drive& drive = *read.rig.driven;
  EXPECT_EQ(drive.start.x_m, 1.0);
  EXPECT_NEAR(drive.start.heading_rad, 0.5 * M_PI, 1e-12);
  EXPECT_NEAR(drive.max_turn_radps, 0.25 * M_PI, 1e-12);
  EXPECT_EQ(drive.max_speed_mps, Drive{}.max_speed_mps);
  ASSERT_EQ(drive.script.size(), 1U);
  EXPECT_EQ(drive.script[0].linear_mps, 0.4);
  EXPECT_NEAR(drive.script[0].angular_radps, -0.5 * M_PI, 1e-12) << "to the right";
}

TEST_F(DriveFile, NamesFileLineAndKeyOfWhatItRefuses) {
  const std::string driven = "[rig.driven]\nposition_m = [0.0, 0.0]\n";
  EXPECT_EQ(complaint(driven), "none");
  EXPECT_THAT(complaint("motion = { kind = \"still\", position_m = [0.0, 0.0] }\n" + driven),
              HasSubstr(":8: rig.motion: a rig that is driven has none of its own"));
  EXPECT_THAT(complaint(driven + "speed = 1\n"), HasSubstr(":10: rig.driven.speed: there is no"));
  EXPECT_THAT(complaint(driven + "acceleration_mps2 = 0\n"),
              HasSubstr(":10: rig.driven.acceleration_mps2: 0 is outside"));
  EXPECT_THAT(complaint("[rig.driven]\nposition_m = [2.9, 0.0]\n"),
              HasSubstr(":9: rig.driven.position_m: is outside the world, or nearer to a wall"));
  EXPECT_THAT(complaint(driven + "[[rig.driven.command]]\nat_s = 2\n[[rig.driven.command]]\n"
                                 "at_s = 2\n"),
              HasSubstr(":13: rig.driven.command[2].at_s: commands must be in the order"));
}

TEST_F(DriveFile, LetsOnlyAWorldWithADrivenRigBeEndless) {
  EXPECT_THAT(complaint("motion = { kind = \"still\", position_m = [0.0, 0.0] }\n", "0"),
              HasSubstr(":1: duration_s: only a world whose rig is driven can be endless"));
}

}  // namespace
}  // namespace egomod::sim
