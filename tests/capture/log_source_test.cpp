// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <optional>

#include "folder_fixture.hpp"
#include "message_fixture.hpp"

namespace egomod {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kJpegGrey = 1;

class LogSourceTest : public TemporaryFolder {
 protected:
  template <typename Message>
  void add(const std::string& channel, const Message& message) {
    if (!writer_) writer_.emplace(path("test.lcmlog"), "w");
    auto bytes = encoded(message);
    lcm::LogEvent event{};
    event.channel = channel;
    event.timestamp = 1;
    event.data = bytes.data();
    event.datalen = static_cast<std::int32_t>(bytes.size());
    ASSERT_EQ(writer_->writeEvent(&event), 0);
  }

  std::unique_ptr<FrameSource> open(const CaptureConfig& config = {}) {
    writer_.reset();
    return open_source("log:" + path("test.lcmlog"), config, "", "");
  }

  std::string error_of_opening_log(const CaptureConfig& config = {}) {
    try {
      static_cast<void>(open(config));
      return {};
    } catch (const SourceError& problem) {
      return problem.what();
    }
  }

  std::optional<lcm::LogFile> writer_;
  StereoPair pair_;
};

TEST_F(LogSourceTest, GivesGreyAndJpegPairsInOrderOfExposure) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", stereo(grey_image(1000, 10), grey_image(1002, 11)));
  add("EGOMOD_IMAGES", stereo(jpeg_image(101000, 30), jpeg_image(101000, 31)));
  add("EGOMOD_IMAGES", stereo(grey_image(51000, 20), grey_image(51000, 21)));
  const auto source = open();
  EXPECT_EQ(source->size(), 3U);
  const std::vector<std::int64_t> utimes{1000, 51000, 101000};
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.sequence, i);
    EXPECT_EQ(pair_.utime_us(), utimes[i]);
    ASSERT_EQ(pair_.status, PairStatus::kOk);
    const int grey = 10 * (static_cast<int>(i) + 1);
    EXPECT_NEAR(pair_.left.row(23)[31], grey, kJpegGrey);
    EXPECT_NEAR(pair_.right.row(23)[31], grey + 1, kJpegGrey);
  }
  EXPECT_EQ(source->next(pair_, {}), SourceState::kEnd);
}

TEST_F(LogSourceTest, ReadsTheWheelsAtEachExposureAlsoFromMessagesThatCameLater) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  for (int i = 0; i < 3; ++i) {
    add("EGOMOD_IMAGES", stereo(grey_image(30000 * i, 1), grey_image(30000 * i, 2)));
  }
  for (int i = 0; i < 4; ++i) add("PIONEER_ODOMETRY", odometry_at(20000 * i, i, 0.01 * i));
  const auto source = open();
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    ASSERT_TRUE(pair_.wheels);
    EXPECT_NEAR(pair_.wheels->T_wheels_body.translation().x(), 0.015 * i, 1e-12);
  }
}

TEST_F(LogSourceTest, HasNoWheelsWhereALogHoldsNone) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 2)));
  const auto source = open();
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_FALSE(pair_.wheels);
}

TEST_F(LogSourceTest, PairsTwoChannelsByExposure) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  for (int i = 0; i < 3; ++i) {
    add("LEFT", grey_image(33000 * i, i));
    if (i != 1) add("RIGHT", grey_image(33000 * i + 4000, 100 + i));
  }
  CaptureConfig config;
  config.left_channel = "LEFT";
  config.right_channel = "RIGHT";
  const auto source = open(config);
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.status, i == 1 ? PairStatus::kRejected : PairStatus::kOk);
    if (i != 1) {
      EXPECT_EQ(pair_.right.row(0)[0], 100 + i);
      EXPECT_EQ(pair_.skew(), std::chrono::milliseconds(4));
    }
  }
}

TEST_F(LogSourceTest, NamesAMessageWithTwoImagesOfOneCamera) {
  for (const std::int16_t camera : {bot_core::images_t::LEFT, bot_core::images_t::RIGHT}) {
    add("EGOMOD_CALIBRATION", rectified_calibration());
    auto images = stereo(grey_image(0, 1), grey_image(0, 2));
    images.image_types = {camera, camera};
    add("EGOMOD_IMAGES", images);
    EXPECT_THAT(error_of_opening_log(),
                AllOf(HasSubstr("event 1 on channel EGOMOD_IMAGES: holds two images of one camera"),
                      HasSubstr("must be one LEFT and one RIGHT")));
  }
}

TEST_F(LogSourceTest, RejectsDamagedImagesAndGoesOn) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 1)));
  auto torn = jpeg_image(33000, 2);
  torn.data.resize(torn.data.size() / 2);
  torn.size = static_cast<std::int32_t>(torn.data.size());
  add("EGOMOD_IMAGES", stereo(torn, jpeg_image(33000, 2)));
  auto short_image = grey_image(66000, 3);
  short_image.data.resize(10);
  short_image.size = 10;
  add("EGOMOD_IMAGES", stereo(short_image, grey_image(66000, 3)));
  auto narrow_stride = grey_image(99000, 3);
  narrow_stride.row_stride = 5;
  add("EGOMOD_IMAGES", stereo(narrow_stride, grey_image(99000, 3)));
  add("EGOMOD_IMAGES", stereo(grey_image(132000, 4), grey_image(132000, 4)));
  const auto source = open();
  for (const PairStatus expected : {PairStatus::kOk, PairStatus::kRejected, PairStatus::kRejected,
                                    PairStatus::kRejected, PairStatus::kOk}) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.status, expected) << pair_.sequence;
  }
}

TEST_F(LogSourceTest, KeepsThePlaceOfAPairWhoseMessageIsDamaged) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 1)));
  bot_core::images_t empty;
  empty.utime = 33000;
  empty.n_images = 0;
  add("EGOMOD_IMAGES", empty);
  auto negative = stereo(grey_image(66000, 1), grey_image(66000, 1));
  negative.images[0].width = -1;
  add("EGOMOD_IMAGES", negative);
  add("EGOMOD_IMAGES", stereo(grey_image(99000, 1), grey_image(99000, 1)));
  const auto source = open();
  ASSERT_EQ(source->size(), 4U);
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.utime_us(), 33000 * i);
    EXPECT_EQ(pair_.fault, i == 1 || i == 2 ? PairFault::kDamaged : PairFault::kNone) << i;
  }
  EXPECT_EQ(source->counters().damaged_messages, 0U);
}

TEST_F(LogSourceTest, KeepsThePlaceOfAPairOfWhichOneChannelIsDamaged) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  for (int i = 0; i < 5; ++i) {
    bot_core::image_t left = grey_image(33000 * i, 1);
    bot_core::image_t right = grey_image(33000 * i, 1);
    if (i == 1) left.height = -1;
    if (i == 3) right.height = -1;
    add("LEFT", left);
    add("RIGHT", right);
  }
  CaptureConfig config;
  config.left_channel = "LEFT";
  config.right_channel = "RIGHT";
  const auto source = open(config);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.fault, i % 2 == 1 ? PairFault::kDamaged : PairFault::kNone) << i;
  }
}

TEST_F(LogSourceTest, CountsDamagedMessagesWhoseTimeIsDamagedToo) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 1)));
  for (const std::int64_t utime_us : {std::int64_t{-1} << 62, std::int64_t{1} << 50}) {
    bot_core::images_t lost;
    lost.utime = utime_us;
    lost.n_images = 0;
    add("EGOMOD_IMAGES", lost);
  }
  add("EGOMOD_IMAGES", stereo(grey_image(33000, 1), grey_image(33000, 1)));
  const auto source = open();
  EXPECT_EQ(source->size(), 2U);
  EXPECT_EQ(source->counters().damaged_messages, 2U);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_FALSE(pair_.discontinuity);
}

TEST_F(LogSourceTest, SaysWhyAPairIsRejected) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("LEFT", grey_image(0, 1));
  CaptureConfig config;
  config.left_channel = "LEFT";
  config.right_channel = "RIGHT";
  ASSERT_EQ(open(config)->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.fault, PairFault::kNoPartner);
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("LEFT", grey_image(0, 1));
  add("RIGHT", grey_image(5'000'000, 1));
  ASSERT_EQ(open(config)->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.fault, PairFault::kSkew);
  EXPECT_EQ(pair_.skew(), std::chrono::seconds(5));
}

TEST_F(LogSourceTest, RefusesCalibrationsThatContradictEachOther) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  auto other = rectified_calibration();
  other.width = other.height = 64;
  add("EGOMOD_CALIBRATION", other);
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 1)));
  EXPECT_THAT(error_of_opening_log(),
              AllOf(HasSubstr("test.lcmlog: its EGOMOD_CALIBRATION messages contradict"),
                    HasSubstr("--rig")));
}

TEST_F(LogSourceTest, GivesTheWholePairsOfATruncatedLogThenFails) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  for (int i = 0; i < 3; ++i) {
    add("EGOMOD_IMAGES", stereo(grey_image(33000 * i, i), grey_image(33000 * i, i)));
  }
  writer_.reset();
  std::filesystem::resize_file(path("test.lcmlog"),
                               std::filesystem::file_size(path("test.lcmlog")) - 100);
  const auto source = open();
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(source->next(pair_, {}), SourceState::kFailed);
  EXPECT_THAT(source->error(), AllOf(HasSubstr("truncated"), HasSubstr("3 whole events")));
}

TEST_F(LogSourceTest, FollowsACalibrationThatChanges) {
  add("EGOMOD_CALIBRATION", rectified_calibration(100.0));
  calibration_t later = rectified_calibration(120.0);
  later.utime = 33000;
  add("EGOMOD_CALIBRATION", later);
  for (int i = 0; i < 2; ++i) {
    add("EGOMOD_IMAGES", stereo(grey_image(33000 * i, i), grey_image(33000 * i, i)));
  }
  const auto source = open();
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.calibration.camera.fx_px, 100.0);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.calibration.camera.fx_px, 120.0);
}

TEST_F(LogSourceTest, MarksAClockThatStepsBack) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  for (const int utime_us : {9000000, 9033000, 1000000, 1033000}) {
    add("EGOMOD_IMAGES", stereo(grey_image(utime_us, 1), grey_image(utime_us, 1)));
  }
  const auto source = open();
  for (const bool expected : {false, false, true, false}) {
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.discontinuity, expected) << pair_.sequence;
  }
}

TEST_F(LogSourceTest, RefusesAnUnknownTypeNamingChannelAndEvent) {
  add("EGOMOD_CALIBRATION", rectified_calibration());
  add("EGOMOD_IMAGES", grey_image(0, 1));
  EXPECT_THAT(error_of_opening_log(),
              AllOf(HasSubstr("event 1"), HasSubstr("EGOMOD_IMAGES"), HasSubstr("images_t")));
}

TEST_F(LogSourceTest, RefusesALogWithoutCalibrationOrImages) {
  add("EGOMOD_IMAGES", stereo(grey_image(0, 1), grey_image(0, 1)));
  EXPECT_THAT(error_of_opening_log(), AllOf(HasSubstr("EGOMOD_CALIBRATION"), HasSubstr("--rig")));
  CaptureConfig config;
  config.left_channel = "A";
  config.right_channel = "B";
  EXPECT_THAT(error_of_opening_log(config), HasSubstr("A and B"));
  config.right_channel = "";
  EXPECT_THAT(error_of_opening_log(config), HasSubstr("capture.right_channel"));
}

TEST_F(LogSourceTest, RefusesWhatIsNoLog) {
  write("test.lcmlog", "this is a text file, and a rather long one for a header");
  EXPECT_THAT(error_of_opening_log(), HasSubstr("not an LCM log"));
  std::filesystem::remove(path("test.lcmlog"));
  EXPECT_THAT(error_of_opening_log(), HasSubstr("cannot be opened"));
}

}  // namespace
}  // namespace egomod
