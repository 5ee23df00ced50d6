// SPDX-License-Identifier: Apache-2.0
// What the real programs say about input that is wrong: the file, the line, what to do about it,
// and an exit code that is not 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <lcm/lcm-cpp.hpp>

#include "kitti_writer.hpp"
#include "run_program.hpp"
#include "scenes.hpp"

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
    fs::create_directories(root_ / "good");
    test_support::SyntheticWorld world(test_support::following_robot(),
                                       test_support::kinect_pair(320));
    test_support::write_kitti_sequence(world, {.rate_hz = 10.0, .pairs = kPairs}, root_ / "good");
    run({EGOMOD_LOG, "import", root_ / "good", root_ / "good.log"});
    run({EGOMODD, kNoBus, "--source=folder:" + (root_ / "good").string(), "--record",
         root_ / "record"});
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

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
  fs::copy_file(root_ / "good.log", root_ / "cut.log", fs::copy_options::overwrite_existing);
  fs::resize_file(root_ / "cut.log", fs::file_size(root_ / "cut.log") - 1000);
  const fs::path record = root_ / "cut_record";
  EXPECT_THAT(refusal_of_source("log:" + (root_ / "cut.log").string(), {"--record", record}),
              AllOf(HasSubstr("cut.log: the log is truncated at byte "),
                    HasSubstr("4 pairs before it were processed")));
  EXPECT_EQ(messages(record, "EGOMOD_POSE"), kPairs - 1);
  EXPECT_THAT(refusal({EGOMOD_LOG, "info", root_ / "cut.log"}), HasSubstr("cut off"));
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
    EXPECT_THAT(refusal(arguments), HasSubstr("text.log: is not an LCM log")) << command;
  }
}

TEST_F(BadInput, a_channel_carries_another_type) {
  EXPECT_THAT(refusal_of_source("log:" + (root_ / "record").string(),
                                {"--set=capture.left_channel=EGOMOD_POSE",
                                 "--set=capture.right_channel=EGOMOD_VELOCITY"}),
              AllOf(HasSubstr("event 1 on channel EGOMOD_POSE"), HasSubstr("bot_core.image_t")));
}

TEST_F(BadInput, a_record_holds_no_images) {
  EXPECT_THAT(refusal_of_source("log:" + (root_ / "record").string()),
              AllOf(HasSubstr("holds no left images on EGOMOD_IMAGES"),
                    HasSubstr("capture.left_channel"), HasSubstr("publish.images")));
  EXPECT_THAT(refusal({EGOMOD_LOG, "draw", root_ / "record", root_ / "out"}),
              HasSubstr("--images"));
  EXPECT_THAT(refusal({EGOMOD_LOG, "export", root_ / "good.log", root_ / "out"}),
              HasSubstr("holds no EGOMOD_POSE; record it with egomodd --record"));
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
              AllOf(HasSubstr("record /dev/full: cannot be written"), HasSubstr("has room")));
  EXPECT_THAT(refusal({EGOMOD_LOG, "import", root_ / "good", "/dev/full"}),
              HasSubstr("record /dev/full: cannot be written"));
  EXPECT_THAT(refusal({EGOMOD_LOG, "export", root_ / "record", root_ / "good.log" / "out"}),
              HasSubstr("is no folder and cannot be made one"));
}

TEST_F(BadInput, the_record_is_the_log_that_is_read) {
  const fs::path log = root_ / "precious.log";
  fs::copy_file(root_ / "good.log", log);
  EXPECT_THAT(refusal_of_source("log:" + log.string(), {"--record", log}),
              HasSubstr("is the log that is read, and would be overwritten"));
  EXPECT_EQ(read(log), read(root_ / "good.log"));
}

TEST_F(BadInput, the_configuration_names_what_is_not_there) {
  const std::string source = "--source=folder:" + (root_ / "good").string();
  EXPECT_THAT(refusal({EGOMODD, source, "--preset=thesys"}), HasSubstr("there are: thesis"));
  EXPECT_THAT(refusal({EGOMODD, source, "--config", root_ / "good"}),
              HasSubstr("good: is not a file that can be read"));
  EXPECT_THAT(refusal({EGOMODD, source, "--config", file("bad.toml", "[capture]\nrate = 3\n")}),
              HasSubstr("bad.toml:2:1: capture.rate: unknown key"));
  EXPECT_THAT(refusal_of_source("webcam"),
              HasSubstr("this build has folder:DIR, log:FILE, lcm and"));
}

}  // namespace
}  // namespace egomod
