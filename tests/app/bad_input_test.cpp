// SPDX-License-Identifier: Apache-2.0
// What the real programs say about input that is wrong: the file, the line, what to do about it,
// and an exit code that is not 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <lcm/lcm-cpp.hpp>

#include "kitti_writer.hpp"
#include "run_program.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kPairs = 5;
const std::string kNoBus = "--lcm-url=memq://";

class BadInput : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::path(::testing::TempDir()) / ("egomod_bad_input_" + std::to_string(getpid()));
    copy_good_folder(root_ / "good");
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  // The first pairs of a rendered sequence.
  static void copy_good_folder(const fs::path& to) {
    const fs::path from = EGOMOD_TEST_SEQUENCES "/slow_320";
    for (const char* side : {"image_0", "image_1"}) {
      fs::create_directories(to / side);
      for (int i = 0; i < kPairs; ++i) {
        const std::string name = "00000" + std::to_string(i) + ".png";
        fs::copy_file(from / side / name, to / side / name);
      }
    }
    fs::copy_file(from / "calib.txt", to / "calib.txt");
    write(to / "times.txt", "0\n0.1\n0.2\n0.3\n0.4\n");
  }
  // Its images as a log, and a record of it: made when a test asks for them.
  static fs::path good_log() {
    const fs::path log = root_ / "good.log";
    if (!fs::exists(log)) run({EGOMOD_LOG, "import", root_ / "good", log});
    return log;
  }
  static fs::path good_record() {
    const fs::path record = root_ / "record";
    if (!fs::exists(record)) {
      run({EGOMODD, kNoBus, "--source=folder:" + (root_ / "good").string(), "--record", record});
    }
    return record;
  }

  static Outcome run(const std::vector<std::string>& command) {
    return run_program(command, root_ / "output");
  }

  // What the program says of the arguments; fails the test unless it refuses them as it should.
  static std::string refusal(const std::vector<std::string>& command) {
    const Outcome outcome = run(command);
    EXPECT_GT(outcome.exit_code, 0) << outcome.output;
    EXPECT_THAT(outcome.output, Not(HasSubstr("terminate called")));
    return outcome.output;
  }
  static std::string refusal_of_source(const std::string& spec,
                                       std::vector<std::string> more = {}) {
    more.insert(more.begin(), {EGOMODD, kNoBus, "--source=" + spec});
    return refusal(more);
  }
  // Of a copy of the good folder after `spoil`; by the daemon and by egomod-log import.
  static std::string refusal_of_folder(const std::function<void(const fs::path&)>& spoil) {
    fs::remove_all(root_ / "bad");
    fs::copy(root_ / "good", root_ / "bad", fs::copy_options::recursive);
    spoil(root_ / "bad");
    const std::string said = refusal_of_source("folder:" + (root_ / "bad").string());
    refusal({EGOMOD_LOG, "import", root_ / "bad", root_ / "imported"});
    EXPECT_FALSE(fs::exists(root_ / "imported")) << "half a log is none";
    EXPECT_FALSE(fs::exists(root_ / "imported.part"));
    return said;
  }
  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  static fs::path file(const std::string& name, const std::string& text) {
    write(root_ / name, text);
    return root_ / name;
  }
  static int messages(const fs::path& log, const std::string& channel) {
    lcm::LogFile reader(log, "r");
    int count = 0;
    while (const lcm::LogEvent* event = reader.readNextEvent()) count += event->channel == channel;
    return count;
  }

  static inline fs::path root_;
};

TEST_F(BadInput, a_folder_that_is_missing_or_holds_no_sequence) {
  EXPECT_THAT(refusal_of_source("folder:/nowhere"),
              HasSubstr("folder:/nowhere: there is no such folder"));
  fs::create_directories(root_ / "empty");
  EXPECT_THAT(refusal_of_source("folder:" + (root_ / "empty").string()),
              HasSubstr("holds neither image_0 (KITTI odometry layout) nor mav0/cam0"));
  EXPECT_THAT(refusal_of_source("folder:" + file("plain", "x").string()),
              HasSubstr("there is no such folder"));
  EXPECT_THAT(refusal({EGOMOD_LOG, "import", "/nowhere", root_ / "imported"}),
              HasSubstr("/nowhere: there is no such folder"));
}

TEST_F(BadInput, one_image_is_missing) {
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { fs::remove(f / "image_0/000002.png"); }),
              HasSubstr("image_0/000002.png is missing: times.txt has 5 times"));
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { fs::remove(f / "image_1/000002.png"); }),
              AllOf(HasSubstr("image_0 has 5 images and image_1 4, first missing"),
                    HasSubstr("image_1/000002.png; restore what is missing"),
                    HasSubstr("times_right.txt")));
}

TEST_F(BadInput, an_image_has_another_size) {
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) {
                const Image small = [] {
                  Image image;
                  image.resize(64, 48);
                  return image;
                }();
                test_support::write_png(f / "image_1/000003.png", small.view());
              }),
              AllOf(HasSubstr("image_1/000003.png: the image is 64x48 pixels"),
                    HasSubstr("must be 320x"), HasSubstr("3 pairs before it were processed")));
}

TEST_F(BadInput, an_image_cannot_be_read) {
  for (const char* text : {"", "junk", "\x89PNG\r\n\x1a\n"}) {
    EXPECT_THAT(
        refusal_of_folder([&](const fs::path& f) { write(f / "image_0/000003.png", text); }),
        AllOf(HasSubstr("image_0/000003.png: unreadable PNG"), HasSubstr("restore"),
              HasSubstr("3 pairs before it were processed")));
  }
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) {
                fs::remove(f / "image_0/000003.png");
                fs::create_directory(f / "image_0/000003.png");
              }),
              HasSubstr("image_0/000003.png: is not a PNG file"));
}

TEST_F(BadInput, the_calibration_is_missing_or_malformed) {
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { fs::remove(f / "calib.txt"); }),
              AllOf(HasSubstr("calib.txt is missing"), HasSubstr("--rig")));
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { write(f / "calib.txt", "\nP0: 1 x\n"); }),
              HasSubstr("calib.txt:2: P0: 'x' is not a number"));
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { write(f / "calib.txt", ""); }),
              HasSubstr("calib.txt: the line 'P0: ...' is missing"));
}

constexpr const char* kRawCalibration =
    "S_00: 320 240\nK_00: 262 0 160 0 262 120 0 0 1\nD_00: 0 0 0 0 0\n"
    "R_rect_00: 1 0 0 0 1 0 0 0 1\nS_rect_00: 320 240\n"
    "S_01: 320 240\nK_01: 262 0 160 0 262 120 0 0 1\nD_01: 0 0 0 0 0\n"
    "R_rect_01: 1 0 0 0 1 0 0 0 1\nS_rect_01: 320 240\n"
    "R_01: 1 0 0 0 1 0 0 0 1\nT_01: -0.375 0 0\n"
    "P_rect_00: 262 0 160 0 0 262 120 0 0 0 1 0\n"
    "P_rect_01: 262 0 160 -98.25 0 262 120 0 0 0 1 0\n";

TEST_F(BadInput, the_calibration_of_raw_images_cannot_be_right) {
  const std::string good = kRawCalibration;
  write(root_ / "good" / "calib_full.txt", good);
  EXPECT_EQ(run({EGOMODD, kNoBus, "--source=folder:" + (root_ / "good").string()}).exit_code, 0);
  fs::remove(root_ / "good" / "calib_full.txt");
  const auto refusal_with = [&](const std::string& line, const std::string& replacement) {
    return refusal_of_folder([&](const fs::path& f) {
      std::string text = good;
      text.replace(text.find(line), line.size(), replacement);
      write(f / "calib_full.txt", text);
    });
  };
  EXPECT_THAT(refusal_with("R_rect_00: 1", "R_rect_00: 2"),
              HasSubstr("calib_full.txt:4: R_rect_00: is not a rotation"));
  EXPECT_THAT(refusal_with("K_01: 262", "K_01: 0"), HasSubstr("calib_full.txt:7: K_01: must be"));
  EXPECT_THAT(refusal_with("S_rect_00: 320 240", "S_rect_00: 320.5 240"),
              HasSubstr("calib_full.txt:5: S_rect_00: is not an image size"));
  EXPECT_THAT(refusal_with("T_01: -0.375 0 0", "T_01: -5 0 0"),
              AllOf(HasSubstr("calib_full.txt:12: T_01:"), HasSubstr("P_rect_01 at (0.375")));
  EXPECT_THAT(refusal_with("S_00: 320 240", "S_00: 320 480"),
              AllOf(HasSubstr("000000.png"), HasSubstr("must be 320x480")));
  EXPECT_THAT(
      refusal_with("K_00: 262 0 160", "K_00: 262 0 1160"),
      AllOf(HasSubstr("calib_full.txt: the rectified image lies outside"), HasSubstr("--rig")));
  EXPECT_THAT(refusal_with("K_00: 262 0 160", "K_00: 262 0 9160"),
              HasSubstr("calib_full.txt:2: K_00: the principal point must lie within"));
  EXPECT_THAT(refusal_with("K_00: 262", "K_00: 1e300"),
              HasSubstr("calib_full.txt:2: K_00: focal lengths must be positive and at most"));
  EXPECT_THAT(refusal_with("D_01: 0 0 0", "D_01: 0 1e4 0"),
              HasSubstr("calib_full.txt:8: D_01: must be coefficients of at most 1000"));
}

TEST_F(BadInput, bytes_that_are_no_text_do_not_reach_the_terminal) {
  const std::string said =
      refusal_of_folder([](const fs::path& f) { write(f / "calib.txt", "\x1b[31m\x07\xff"); });
  EXPECT_THAT(said, HasSubstr("found '\\x1b[31m\\x07\\xff'"));
}

TEST_F(BadInput, not_one_pair_can_be_used) {
  EXPECT_THAT(
      refusal_of_source("log:" + good_log().string(),
                        {"--set=capture.left_channel=LEFT", "--set=capture.right_channel=RIGHT"}),
      HasSubstr("holds no left images on LEFT and RIGHT"));
  fs::copy(root_ / "good", root_ / "late", fs::copy_options::recursive);
  write(root_ / "late" / "times_right.txt", "100\n100.1\n100.2\n100.3\n100.4\n");
  EXPECT_THAT(refusal_of_source("folder:" + (root_ / "late").string()),
              AllOf(HasSubstr("5 of 5 pairs were rejected"),
                    HasSubstr("no pair could be used, the nearest right image is 99.6 s")));
}

TEST_F(BadInput, some_pairs_cannot_be_used) {
  fs::copy(root_ / "good", root_ / "some", fs::copy_options::recursive);
  write(root_ / "some" / "times_right.txt", "0\n0.1\n0.2\n0.39\n0.4\n");
  const Outcome outcome =
      run({EGOMODD, kNoBus, "--quiet", "--source=folder:" + (root_ / "some").string()});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("warning: 1 of 5 pairs were rejected: 1 whose images are "
                                        "too far apart in time"));
}

TEST_F(BadInput, counts_disagree_without_times_of_the_right_camera) {
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { fs::remove(f / "image_1/000004.png"); }),
              AllOf(HasSubstr("image_0 has 5 images and image_1 4"), HasSubstr("times_right.txt")));
  EXPECT_THAT(refusal_of_folder([](const fs::path& f) { write(f / "times.txt", ""); }),
              HasSubstr("times.txt has 0 times; each image needs one"));
}

TEST_F(BadInput, times_run_backwards_repeat_or_are_no_numbers) {
  const auto refusal_of_times = [](const std::string& text) {
    return refusal_of_folder([&](const fs::path& f) { write(f / "times.txt", text); });
  };
  EXPECT_THAT(refusal_of_times("0\n0.1\n0.05\n0.3\n0.4\n"),
              HasSubstr("times.txt:3: the time runs backwards"));
  EXPECT_THAT(refusal_of_times("0\n0.1\n0.1\n0.3\n0.4\n"),
              HasSubstr("times.txt:3: the time repeats"));
  EXPECT_THAT(refusal_of_times("0\nsoon\n"), HasSubstr("times.txt:2: 'soon' is not a number"));
}

TEST_F(BadInput, a_truncated_log_is_used_as_far_as_it_is_whole) {
  fs::copy_file(good_log(), root_ / "cut.log", fs::copy_options::overwrite_existing);
  fs::resize_file(root_ / "cut.log", fs::file_size(root_ / "cut.log") - 1000);
  const fs::path record = root_ / "cut_record";
  EXPECT_THAT(refusal_of_source("log:" + (root_ / "cut.log").string(), {"--record", record}),
              AllOf(HasSubstr("cut.log: the log is truncated at byte "),
                    HasSubstr("4 pairs before it were processed")));
  EXPECT_EQ(messages(record, "EGOMOD_POSE"), kPairs - 1);
  EXPECT_THAT(refusal({EGOMOD_LOG, "info", root_ / "cut.log"}),
              HasSubstr("cut.log: the log is truncated at byte "));
}

TEST_F(BadInput, what_is_named_as_a_log_is_none) {
  const std::string text = file("text.log", "This is no log, however long the text may be.");
  EXPECT_THAT(refusal_of_source("log:" + text), HasSubstr("text.log: not an LCM log"));
  EXPECT_THAT(refusal_of_source("log:/nowhere.log"), HasSubstr("/nowhere.log: cannot be opened"));
  EXPECT_THAT(refusal_of_source("log:" + (root_ / "good").string()), HasSubstr("is not a file"));
  EXPECT_THAT(refusal_of_source("log:" + file("empty.log", "").string()),
              HasSubstr("holds no left images on EGOMOD_IMAGES"));
  for (const char* command : {"info", "export", "draw"}) {
    std::vector<std::string> arguments{EGOMOD_LOG, command, text, root_ / "out"};
    arguments.resize(command == std::string("info") ? 3 : 4);
    EXPECT_THAT(refusal(arguments), HasSubstr("text.log: not an LCM log")) << command;
  }
}

TEST_F(BadInput, a_channel_carries_another_type) {
  EXPECT_THAT(refusal_of_source("log:" + good_record().string(),
                                {"--set=capture.left_channel=EGOMOD_POSE",
                                 "--set=capture.right_channel=EGOMOD_VELOCITY"}),
              AllOf(HasSubstr("event 1 on channel EGOMOD_POSE"), HasSubstr("bot_core.image_t")));
}

TEST_F(BadInput, a_record_holds_no_images) {
  EXPECT_THAT(refusal_of_source("log:" + good_record().string()),
              AllOf(HasSubstr("holds no left images on EGOMOD_IMAGES"),
                    HasSubstr("capture.left_channel"), HasSubstr("publish.images")));
  EXPECT_THAT(refusal({EGOMOD_LOG, "draw", good_record(), root_ / "out"}), HasSubstr("--images"));
  EXPECT_THAT(refusal({EGOMOD_LOG, "export", good_log(), root_ / "out"}),
              HasSubstr("holds no EGOMOD_POSE; record it with egomodd --record"));
}

TEST_F(BadInput, a_record_is_drawn_on_the_images_of_another_sequence) {
  const fs::path other = root_ / "other";
  const auto refusal_with = [&](const std::function<void()>& change) {
    fs::remove_all(other);
    fs::copy(root_ / "good", other, fs::copy_options::recursive);
    change();
    const fs::path pictures = root_ / "pictures_of_another";
    const std::string said =
        refusal({EGOMOD_LOG, "draw", good_record(), pictures, "--images", other});
    EXPECT_FALSE(fs::exists(pictures));
    EXPECT_THAT(said, AllOf(HasSubstr("record: is not a record of " + other.string()),
                            HasSubstr("name its own sequence with --images")));
    return said;
  };
  EXPECT_THAT(refusal_with([&] { write(other / "times.txt", "0\n0.1\n0.25\n0.3\n0.4\n"); }),
              HasSubstr("no left image has the time of its pair 2, 0.200000 s"));
  EXPECT_THAT(refusal_with([&] {
                fs::remove(other / "image_0/000004.png");
                fs::remove(other / "image_1/000004.png");
                write(other / "times.txt", "0\n0.1\n0.2\n0.3\n");
              }),
              HasSubstr("it has 5 pairs, the folder 4"));
  EXPECT_THAT(refusal_with([&] {
                Image small;
                small.resize(64, 48);
                for (const char* side : {"image_0", "image_1"}) {
                  for (int i = 0; i < kPairs; ++i) {
                    const std::string name = "00000" + std::to_string(i) + ".png";
                    test_support::write_png(other / side / name, small.view());
                  }
                }
              }),
              HasSubstr("it is of images of 320x240 pixels, not 64x48"));
  EXPECT_EQ(run({EGOMOD_LOG, "draw", good_record(), root_ / "pictures", "--images", root_ / "good"})
                .exit_code,
            0);
}

TEST_F(BadInput, a_rig_file_is_malformed) {
  const auto refusal_of_rig = [](const std::string& text) {
    return refusal_of_source("folder:" + (root_ / "good").string(),
                             {"--rig", file("rig.toml", text)});
  };
  EXPECT_THAT(refusal_of_rig("[rectified]\nsize_px = [320, 240]\nfx = 3\n"),
              HasSubstr("rig.toml:3: rectified.fx is not a key of a rig file"));
  EXPECT_THAT(refusal_of_rig("[left"), HasSubstr("rig.toml:1: "));
  EXPECT_THAT(refusal_of_rig(""), HasSubstr("rectified is missing"));
  EXPECT_THAT(refusal_of_rig(R"([rectified]
size_px = [320, 240]
fx_px = 262
fy_px = 262
cx_px = 160
cy_px = 120
baseline_m = 0.375
[T_body_camera]
matrix = [0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0, 5, 5, 5, 2]
)"),
              HasSubstr("rig.toml:9: T_body_camera.matrix is not a rigid transform"));
  for (const char* path : {"/nowhere/rig.toml", "/"}) {
    EXPECT_THAT(refusal_of_source("folder:" + (root_ / "good").string(), {"--rig", path}),
                HasSubstr(std::string(path) + ": is not a file that can be read"));
  }
}

TEST_F(BadInput, the_record_cannot_be_written) {
  const std::string source = "folder:" + (root_ / "good").string();
  EXPECT_THAT(refusal_of_source(source, {"--record=/nowhere/record"}),
              AllOf(HasSubstr("record /nowhere/record: cannot be written (No such file"),
                    HasSubstr("name a file in a folder that exists")));
  EXPECT_THAT(refusal_of_source(source, {"--record", root_ / "good"}), HasSubstr("Is a directory"));
  EXPECT_THAT(refusal_of_source(source, {"--record=/dev/full"}),
              AllOf(HasSubstr("record /dev/full: cannot be written (No space left on device)"),
                    HasSubstr("has room"), HasSubstr("pairs before it were processed"),
                    HasSubstr("\nlatency, ms")));
  EXPECT_THAT(refusal({EGOMOD_LOG, "import", root_ / "good", "/dev/full"}),
              HasSubstr("record /dev/full: cannot be written"));
  EXPECT_THAT(refusal({EGOMOD_LOG, "export", good_record(), good_log() / "out"}),
              HasSubstr("is no folder and cannot be made one"));
}

TEST_F(BadInput, the_record_is_the_log_that_is_read) {
  const fs::path log = root_ / "precious.log";
  fs::copy_file(good_log(), log);
  EXPECT_THAT(refusal_of_source("log:" + log.string(), {"--record", log}),
              HasSubstr("is the log that is read, and would be overwritten"));
  EXPECT_EQ(read(log), read(good_log()));
}

TEST_F(BadInput, the_record_is_a_file_of_the_sequence_that_is_read) {
  const fs::path folder = root_ / "precious";
  fs::copy(root_ / "good", folder, fs::copy_options::recursive);
  fs::create_symlink(folder / "calib.txt", root_ / "innocent");
  fs::create_hard_link(folder / "image_1/000004.png", root_ / "harmless");
  for (const fs::path& record :
       {folder / "image_0/000002.png", folder / "times.txt", root_ / "innocent", root_ / "harmless",
        folder / "image_0" / ".." / "calib.txt"}) {
    EXPECT_THAT(refusal_of_source("folder:" + folder.string(), {"--record", record}),
                HasSubstr("record " + record.string() +
                          ": is a file of the sequence that is read, and would be overwritten"));
  }
  for (const char* name : {"image_0/000002.png", "image_1/000004.png", "times.txt", "calib.txt"}) {
    EXPECT_EQ(read(folder / name), read(root_ / "good" / name)) << name;
  }
}

TEST_F(BadInput, an_earlier_record_in_the_folder_of_the_sequence_is_written_anew) {
  const fs::path folder = root_ / "twice";
  fs::copy(root_ / "good", folder, fs::copy_options::recursive);
  for (int i = 0; i < 2; ++i) {
    const Outcome outcome = run({EGOMODD, kNoBus, "--source=folder:" + folder.string(), "--record",
                                 folder / "record.lcmlog"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  }
}

TEST_F(BadInput, the_record_is_the_rig_file_or_the_configuration) {
  const std::string source = "folder:" + (root_ / "good").string();
  const std::string rig_text =
      "[rectified]\nsize_px = [320, 240]\nfx_px = 262\nfy_px = 262\ncx_px = 160\n"
      "cy_px = 120\nbaseline_m = 0.375\n";
  const std::string rig = file("my_rig.toml", rig_text);
  EXPECT_THAT(refusal_of_source(source, {"--rig", rig, "--record", rig}),
              HasSubstr("my_rig.toml: is the rig file, and would be overwritten"));
  EXPECT_EQ(read(rig), rig_text);
  for (const char* option : {"--config", "--preset"}) {
    const std::string config = file("my_config.toml", "[logging]\nlevel = \"info\"\n");
    const std::string before = read(config);
    EXPECT_THAT(refusal_of_source(source, {option, config, "--record", config}),
                HasSubstr("my_config.toml: is the configuration file, and would be overwritten"));
    EXPECT_EQ(read(config), before) << option;
  }
}

TEST_F(BadInput, the_configuration_names_what_is_not_there) {
  const std::string source = "--source=folder:" + (root_ / "good").string();
  EXPECT_THAT(refusal({EGOMODD, source, "--preset=thesys"}), HasSubstr("there are: thesis"));
  EXPECT_THAT(refusal({EGOMODD, source, "--config", root_ / "good"}),
              HasSubstr("good: is not a file that can be read"));
  EXPECT_THAT(refusal({EGOMODD, source, "--config", file("bad.toml", "[capture]\nrate = 3\n")}),
              HasSubstr("bad.toml:2:1: capture.rate: unknown key"));
  EXPECT_THAT(refusal_of_source("webcam"), HasSubstr("this build has folder:DIR, log:FILE"));
}

}  // namespace
}  // namespace egomod
