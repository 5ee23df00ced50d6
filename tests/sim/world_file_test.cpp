// SPDX-License-Identifier: Apache-2.0
#include "world_file.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "small_world.hpp"

namespace egomod::sim {
namespace {

using testing::HasSubstr;

const std::string kGood =
    "duration_s = 1.0\n[camera]\n[shell]\nkind = \"room\"\nwidth_m = 6.0\nlength_m = 8.0\n"
    "[rig]\nmotion = { kind = \"still\", position_m = [0.0, 0.0] }\n";

// "LINE: key: what" of what the file is refused for.
std::string complaint(const std::string& text) {
  try {
    (void)test::world_of(text);
  } catch (const WorldError& error) {
    const std::string what = error.what();
    const std::size_t line = what.find(".toml:");
    return line == std::string::npos ? what : what.substr(line + 6);
  }
  return "none";
}

std::string with(const std::string& lines) { return complaint(kGood + lines); }
// In the table's first line.
std::string in(const std::string& table, const std::string& line) {
  std::string text = kGood;
  text.insert(text.find("[" + table + "]") + table.size() + 3, line + "\n");
  return complaint(text);
}
std::string object(const std::string& lines) { return with("[[object]]\n" + lines); }
std::string pioneer(const std::string& motion) {
  return object("kind = \"pioneer\"\nmotion = " + motion + "\n");
}

TEST(WorldFile, EveryShippedWorldCanBeRead) {
  const auto names = worlds_in(EGOMOD_WORLDS_DIR);
  EXPECT_GE(names.size(), 26U);
  for (const std::string& name : names) {
    EXPECT_NO_THROW((void)read_world(find_world(name, EGOMOD_WORLDS_DIR))) << name;
  }
  EXPECT_EQ(complaint(kGood), "none");
  EXPECT_EQ(complaint(test::unreal_room()), "none");
}

TEST(WorldFile, RefusesKeysThatItDoesNotKnow) {
  EXPECT_THAT(complaint("speed = 1\n" + kGood), HasSubstr("1: speed: there is no such key"));
  EXPECT_THAT(in("camera", "zoom = 2"),
              HasSubstr("3: camera.zoom: there is no such key; there are:"));
  EXPECT_THAT(in("camera", "zoom = 2"), HasSubstr("baseline_m"));
  EXPECT_THAT(with("[timings]\n"), HasSubstr("9: timings: there is no such key"));
  EXPECT_THAT(pioneer("{ kind = \"still\", position_m = [0.0, 2.0], turn_degps = 3.0 }"),
              HasSubstr("11: object[1].motion.turn_degps: there is no such key"));
}

TEST(WorldFile, RefusesWhatIsMissing) {
  EXPECT_THAT(complaint("duration_s = 1.0\n"), HasSubstr("1: shell: is missing"));
  EXPECT_THAT(object("kind = \"car\"\n"), HasSubstr("9: object[1].motion: is missing"));
  EXPECT_THAT(pioneer("{ kind = \"line\", position_m = [0.0, 2.0] }"),
              HasSubstr("11: object[1].motion.speed_mps: is missing"));
}

TEST(WorldFile, RefusesWhatIsNoFiniteNumberInRange) {
  EXPECT_THAT(in("camera", "width_px = 640.5"), HasSubstr("3: camera.width_px: a whole number"));
  EXPECT_THAT(in("camera", "baseline_m = \"wide\""), HasSubstr("3: camera.baseline_m: a number"));
  EXPECT_THAT(in("camera", "baseline_m = 0.0"),
              HasSubstr("3: camera.baseline_m: 0 is outside 0.001"));
  EXPECT_THAT(in("camera", "focal_px = inf"), HasSubstr("3: camera.focal_px: must be finite"));
  EXPECT_THAT(pioneer("{ kind = \"still\", position_m = [nan, 1.0] }"),
              HasSubstr("11: object[1].motion.position_m: must be finite"));
  EXPECT_THAT(object("kind = \"box\"\nsize_m = [0.0, 1.0, 1.0]\n"),
              HasSubstr("11: object[1].size_m: 0 is outside 0.01"));
  EXPECT_THAT(object("kind = \"box\"\nsize_m = [1.0, 1.0]\n"),
              HasSubstr("11: object[1].size_m: a list of 3 numbers"));
  EXPECT_THAT(object("kind = \"bus\"\n"),
              HasSubstr("10: object[1].kind: must be one of box, pioneer"));
}

TEST(WorldFile, RefusesWhatIsOutsideOrInTheWay) {
  EXPECT_THAT(pioneer("{ kind = \"still\", position_m = [9.0, 1.0] }"),
              HasSubstr("11: object[1].motion: at 0.00 s it is outside the world"));
  EXPECT_THAT(pioneer("{ kind = \"line\", position_m = [0.0, 4.0], speed_mps = 4.0 }"),
              HasSubstr("it is outside the world"));
  EXPECT_THAT(
      pioneer("{ kind = \"line\", position_m = [0.0, 1.0], heading_deg = 180.0, speed_mps = 1.0 }"),
      HasSubstr("it runs into the rig"));
  EXPECT_THAT(
      with("[[furniture]]\nposition_m = [1.02, 3.0]\nsize_m = [0.5, 0.5, 0.5]\n"
           "[[object]]\nkind = \"pioneer\"\n"
           "motion = { kind = \"line\", position_m = [-1.0, 3.0], heading_deg = 90.0, "
           "speed_mps = 2.0 }\n"),
      HasSubstr("14: object[1].motion: at 0.80 s, at x 0.60, z 3.00 m, it runs into furniture[1]"));
  EXPECT_THAT(with("[[furniture]]\nposition_m = [2.9, 3.0]\nsize_m = [0.5, 0.5, 0.5]\n"),
              HasSubstr("10: furniture[1].position_m: at 0.00 s it is outside"));
  EXPECT_THAT(with("[[poster]]\nwall = \"front\"\nalong_m = 2.9\n"),
              HasSubstr("11: poster[1].along_m: it hangs beyond the wall"));
  EXPECT_THAT(in("rig", "height_m = 3.0"), HasSubstr("8: rig.height_m: is above the ceiling"));
}

TEST(WorldFile, RefusesKnobsThatContradictEachOther) {
  EXPECT_THAT(with("[realism]\nexposure_s = 0.01\n"),
              HasSubstr("10: realism.exposure_s: blurs only"));
  EXPECT_THAT(with("[realism]\nblur_samples = 4\n"),
              HasSubstr("10: realism.blur_samples: needs exposure_s"));
  EXPECT_THAT(with("[realism]\nreadout_strips = 9\n"),
              HasSubstr("10: realism.readout_strips: needs readout_s"));
  EXPECT_THAT(with("[realism]\nreadout_s = 0.05\n"),
              HasSubstr("10: realism.readout_s: is longer than the 0.0333 s"));
  EXPECT_THAT(with("[timing]\nlate_s = 0.1\n"),
              HasSubstr("10: timing.late_s: needs late_probability"));
  EXPECT_THAT(with("[timing]\nlate_probability = 0.1\n"),
              HasSubstr("10: timing.late_probability: needs late_s"));
  EXPECT_THAT(with("[timing]\njitter_s = 0.01\n"),
              HasSubstr("10: timing.jitter_s: is more than 0.15 of"));
  EXPECT_THAT(with("[timing]\nright_offset_s = 0.04\n"),
              HasSubstr("10: timing.right_offset_s: is more than"));
  EXPECT_THAT(
      pioneer("{ kind = \"arc\", position_m = [0.0, 2.0], speed_mps = 0.0, turn_degps = 9.0 }"),
      HasSubstr("11: object[1].motion.speed_mps: an arc needs some"));
  EXPECT_THAT(
      pioneer("{ kind = \"line\", position_m = [0.0, 2.0], speed_mps = 0.1, pause_s = 1.0 }"),
      HasSubstr("11: object[1].motion.pause_s: needs go_s"));
}

TEST(WorldFile, RefusesLensesThatCannotBe) {
  EXPECT_THAT(with("[camera.left]\ndistortion = [-0.6, 0.0, 0.0, 0.0, 0.0]\n"),
              HasSubstr("10: camera.left.distortion: the lens folds back"));
  EXPECT_THAT(with("[camera.right]\nfocal_px = 540.0\n"),
              HasSubstr("10: camera.right.focal_px: the rectified image reaches 8.6 px beyond"));
  EXPECT_THAT(with("[camera.right]\nyaw_deg = 1.0\n"), HasSubstr("reaches"));
}

TEST(WorldFile, NamesTheLineThatIsNoToml) {
  EXPECT_THAT(complaint("duration_s = 1.0\nseed == 3\n"), testing::StartsWith("2: "));
}

TEST(WorldFile, OffersTheWorldsThereAre) {
  try {
    (void)find_world("corridoor", EGOMOD_WORLDS_DIR);
    FAIL();
  } catch (const WorldError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("corridoor: no such world"),
                                             HasSubstr("corridor, crossing")));
  }
}

}  // namespace
}  // namespace egomod::sim
