// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stop_token>
#include <vector>

#include "egomod/capture/frame_source.hpp"
#include "folder_fixture.hpp"

namespace egomod {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

CaptureConfig with_rate(double max_rate_hz) {
  CaptureConfig config;
  config.max_rate_hz = max_rate_hz;
  return config;
}

CaptureConfig with_skew(double max_skew_s) {
  CaptureConfig config;
  config.max_skew_s = max_skew_s;
  return config;
}

class FolderSourceTest : public TemporaryFolder {
 protected:
  struct Seen {
    std::uint64_t sequence;
    std::int64_t utime_us;
    PairStatus status;
  };

  // Reads to the end; the state it ended in is in `end_`, its error in `error_`.
  std::vector<Seen> read_all(const CaptureConfig& config = {}) {
    const auto source = open_source(spec(), config, "", "");
    std::vector<Seen> seen;
    StereoPair pair;
    while ((end_ = source->next(pair, {})) == SourceState::kPair) {
      seen.push_back({pair.sequence, pair.utime_us(), pair.status});
    }
    error_ = source->error();
    return seen;
  }

  SourceState end_ = SourceState::kPair;
  std::string error_;
};

TEST_F(FolderSourceTest, GivesEveryPairInOrderWithItsPixelsTimesAndCalibration) {
  write_kitti(3);
  const auto source = open_source(spec(), {}, "", "");
  EXPECT_TRUE(source->is_replay());
  EXPECT_EQ(source->size(), 3U);
  StereoPair pair;
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
    EXPECT_EQ(pair.sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(pair.exposure, std::chrono::milliseconds(100 * i));
    EXPECT_EQ(pair.skew(), Nanoseconds(0));
    EXPECT_EQ(pair.status, PairStatus::kOk);
    ASSERT_EQ(pair.left.width_px(), kWidth_px);
    EXPECT_EQ(pair.left.row(29)[39], 10 * i);
    EXPECT_EQ(pair.right.row(29)[39], 10 * i + 5);
    EXPECT_EQ(pair.calibration.camera,
              (StereoCamera{525, 525, 320.6, 238.7, 0.375, kWidth_px, kHeight_px}));
  }
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
  EXPECT_EQ(source->next(pair, {}), SourceState::kEnd);
}

TEST_F(FolderSourceTest, RoundsTimesToMicroseconds) {
  write_kitti(3);
  write("times.txt", "0\n3.3333350e-02\n1317384506.4000005\n");
  const auto seen = read_all();
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].utime_us, 0);
  EXPECT_EQ(seen[1].utime_us, 33333);
  EXPECT_EQ(seen[2].utime_us, std::llround(1e6 * 1317384506.4000005));
}

TEST_F(FolderSourceTest, KeepsExactlyEverySixthOf30HzAt5Hz) {
  write_kitti(25, 1.0 / 30.0);
  const auto seen = read_all(with_rate(5.0));
  ASSERT_EQ(seen.size(), 25U);
  for (const Seen& pair : seen) {
    EXPECT_EQ(pair.status, pair.sequence % 6 == 0 ? PairStatus::kOk : PairStatus::kSkipped)
        << pair.sequence;
  }
}

TEST_F(FolderSourceTest, PairsByExposureWhereTheRightCameraHasTimesOfItsOwn) {
  write_kitti(4);
  // The right camera runs 20 ms late and missed the instant of the second left image.
  std::filesystem::remove(path("image_1/000003.png"));
  write("times_right.txt", "0.02\n0.22\n0.32\n");
  const auto source = open_source(spec(), {}, "", "");
  StereoPair pair;
  const std::vector<int> right_grey{5, -1, 15, 25};
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
    EXPECT_EQ(pair.sequence, i);
    if (right_grey[i] < 0) {
      EXPECT_EQ(pair.status, PairStatus::kRejected);
      EXPECT_TRUE(pair.right.empty());
    } else {
      EXPECT_EQ(pair.status, PairStatus::kOk);
      EXPECT_EQ(pair.right.row(0)[0], right_grey[i]);
      EXPECT_EQ(pair.skew(), std::chrono::milliseconds(20));
    }
  }
}

TEST_F(FolderSourceTest, HonoursTheConfiguredSkewLimit) {
  write_kitti(4);
  write_times("times_right.txt", 4, 0.1, 0.02);
  for (const Seen& pair : read_all(with_skew(0.019))) {
    EXPECT_EQ(pair.status, PairStatus::kRejected);
  }
  for (const Seen& pair : read_all(with_skew(0.021))) EXPECT_EQ(pair.status, PairStatus::kOk);
}

TEST_F(FolderSourceTest, TurnsColourAndSixteenBitsIntoGrey) {
  write_kitti(1);
  write_rgb_png("image_0/000000.png", kWidth_px, kHeight_px, 200, 100, 50);
  write_png16("image_1/000000.png", kWidth_px, kHeight_px, 0x80FF);
  const auto source = open_source(spec(), {}, "", "");
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.left.row(3)[7], (77 * 200 + 150 * 100 + 29 * 50 + 128) / 256);
  EXPECT_NEAR(pair.right.row(3)[7], 0x80FF / 257.0, 0.5);
}

TEST_F(FolderSourceTest, StopsWhenAsked) {
  write_kitti(2);
  const auto source = open_source(spec(), {}, "", "");
  std::stop_source stop;
  stop.request_stop();
  StereoPair pair;
  EXPECT_EQ(source->next(pair, stop.get_token()), SourceState::kStopped);
}

TEST_F(FolderSourceTest, AppliesANewCalibrationToTheNextPair) {
  write_kitti(2);
  const auto source = open_source(spec(), {}, "", "");
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  Calibration changed = pair.calibration;
  changed.camera.fx_px = 530.0;
  source->set_calibration(changed);
  EXPECT_EQ(pair.calibration.camera.fx_px, 525.0);
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.calibration.camera.fx_px, 530.0);
  changed.camera.width_px += 1;
  EXPECT_THROW(source->set_calibration(changed), SourceError);
  changed = pair.calibration;
  changed.camera.baseline_m = -0.1;
  EXPECT_THROW(source->set_calibration(changed), SourceError);
}

TEST_F(FolderSourceTest, FailsAtAnUnreadableImageAfterGivingAllBefore) {
  write_kitti(4);
  std::filesystem::resize_file(path("image_1/000002.png"),
                               std::filesystem::file_size(path("image_1/000002.png")) - 20);
  EXPECT_EQ(read_all().size(), 2U);
  EXPECT_EQ(end_, SourceState::kFailed);
  EXPECT_THAT(error_, AllOf(HasSubstr("image_1/000002.png"), HasSubstr("unreadable PNG")));
}

TEST_F(FolderSourceTest, FailsAtAnImageOfAnotherSize) {
  write_kitti(3);
  write_png("image_0/000002.png", kWidth_px + 1, kHeight_px, [](int, int) { return 0; });
  EXPECT_EQ(read_all().size(), 2U);
  EXPECT_EQ(end_, SourceState::kFailed);
  EXPECT_THAT(error_, AllOf(HasSubstr("image_0/000002.png"), HasSubstr("41x30")));
}

TEST_F(FolderSourceTest, RefusesLeftAndRightOfDifferentSizeAtOnce) {
  write_kitti(2);
  write_png("image_1/000000.png", kWidth_px, kHeight_px + 2, [](int, int) { return 0; });
  EXPECT_THAT(error_of_opening(), AllOf(HasSubstr("image_1/000000.png"), HasSubstr("40x32")));
}

struct Damage {
  const char* name;
  void (*inflict)(const std::filesystem::path& folder);
  std::vector<std::string> expected;  // parts of the message
};

void PrintTo(const Damage& damage, std::ostream* out) { *out << damage.name; }

class DamagedFolderTest : public TemporaryFolder, public ::testing::WithParamInterface<Damage> {};

TEST_P(DamagedFolderTest, IsRefusedNamingFileAndRemedy) {
  write_kitti(4);
  GetParam().inflict(folder_);
  const std::string error = error_of_opening();
  for (const std::string& part : GetParam().expected) EXPECT_THAT(error, HasSubstr(part));
}

namespace fs = std::filesystem;

void overwrite(const fs::path& file, const std::string& text) {
  std::FILE* stream = std::fopen(file.c_str(), "w");
  ASSERT_NE(stream, nullptr);
  std::fputs(text.c_str(), stream);
  std::fclose(stream);
}

constexpr const char* kP0 = "P0: 525 0 320 0 0 525 238 0 0 0 1 0\n";

INSTANTIATE_TEST_SUITE_P(
    All, DamagedFolderTest,
    ::testing::Values(
        Damage{"no_folder", [](const fs::path& d) { fs::remove_all(d); }, {"no such folder"}},
        Damage{"no_layout",
               [](const fs::path& d) { fs::remove_all(d / "image_0"); },
               {"neither image_0", "mav0"}},
        Damage{"no_right_folder",
               [](const fs::path& d) { fs::remove_all(d / "image_1"); },
               {"image_1", "missing"}},
        Damage{"no_calibration",
               [](const fs::path& d) { fs::remove(d / "calib.txt"); },
               {"calib.txt is missing", "--rig"}},
        Damage{"no_times",
               [](const fs::path& d) { fs::remove(d / "times.txt"); },
               {"times.txt is missing"}},
        Damage{"left_image_missing",
               [](const fs::path& d) { fs::remove(d / "image_0/000001.png"); },
               {"image_0/000001.png is missing"}},
        Damage{"last_left_image_missing",
               [](const fs::path& d) { fs::remove(d / "image_0/000003.png"); },
               {"image_0/000003.png is missing"}},
        Damage{"right_image_missing",
               [](const fs::path& d) { fs::remove(d / "image_1/000002.png"); },
               {"image_1/000002.png", "4 images", "3", "times_right.txt"}},
        Damage{"too_few_times",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\n1\n2\n"); },
               {"4 images", "3 times"}},
        Damage{"times_backwards",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\n2\n1\n3\n"); },
               {"times.txt:3", "backwards"}},
        Damage{"times_repeat",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\n1\n1.0000001\n3\n"); },
               {"times.txt:3", "repeats"}},
        Damage{"times_not_numbers",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\none\n2\n3\n"); },
               {"times.txt:2", "'one' is not a number"}},
        Damage{"times_nan",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\nnan\n2\n3\n"); },
               {"times.txt:2", "not finite"}},
        Damage{"two_times_in_a_line",
               [](const fs::path& d) { overwrite(d / "times.txt", "0\n1 2\n2\n3\n"); },
               {"times.txt:2", "one time"}},
        Damage{"right_times_and_images_disagree",
               [](const fs::path& d) { overwrite(d / "times_right.txt", "0\n1\n2\n"); },
               {"image_1", "times_right.txt", "3 times"}},
        Damage{"no_P1",
               [](const fs::path& d) { overwrite(d / "calib.txt", kP0); },
               {"calib.txt", "'P1: ...' is missing"}},
        Damage{"no_key",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt", std::string(kP0) + "525 0 0\n");
               },
               {"calib.txt:2", "key: values"}},
        Damage{"eleven_numbers",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt", std::string(kP0) + "P1: 1 2 3 4 5 6 7 8 9 10 11\n");
               },
               {"calib.txt:2", "11 numbers"}},
        Damage{"calibration_nan",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt",
                           std::string(kP0) + "P1: nan 0 320 -196 0 525 238 0 0 0 1 0\n");
               },
               {"calib.txt:2", "not finite"}},
        Damage{"fx_differs",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt",
                           std::string(kP0) + "P1: 526 0 320 -196 0 525 238 0 0 0 1 0\n");
               },
               {"not a rectified pair", "fx"}},
        Damage{"cx_differs",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt",
                           std::string(kP0) + "P1: 525 0 330 -196 0 525 238 0 0 0 1 0\n");
               },
               {"not a rectified pair", "cx"}},
        Damage{"swapped",
               [](const fs::path& d) {
                 overwrite(d / "calib.txt",
                           std::string(kP0) + "P1: 525 0 320 196 0 525 238 0 0 0 1 0\n");
               },
               {"baseline", "swapped"}},
        Damage{"first_image_is_no_png",
               [](const fs::path& d) { overwrite(d / "image_0/000000.png", "hello"); },
               {"image_0/000000.png", "unreadable PNG"}}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(OpenSource, ListsWhatIsAvailableForAnUnknownSource) {
  try {
    static_cast<void>(open_source("freenect", {}, "", ""));
    FAIL();
  } catch (const SourceError& problem) {
    EXPECT_THAT(problem.what(), AllOf(HasSubstr("freenect"), HasSubstr("folder:DIR"),
                                      HasSubstr("log:FILE"), HasSubstr("lcm")));
  }
}

}  // namespace
}  // namespace egomod
