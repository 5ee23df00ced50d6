// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/publisher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <egomod/calibration_t.hpp>
#include <limits>
#include <thread>

#include "egomod/publish/record_writer.hpp"
#include "example_frame.hpp"

namespace egomod {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kNoBus = "no-such-provider://";

std::vector<std::string> channels_of(const std::vector<test::Event>& events) {
  std::vector<std::string> channels;
  for (const test::Event& event : events) channels.push_back(event.channel);
  return channels;
}

void record(const std::string& path, const PublishConfig& config, const std::string& bus = kNoBus) {
  Publisher publisher(config, {.lcm_url = bus, .record = path});
  for (std::uint64_t i = 0; i < 3; ++i) publisher.publish(test::some_frame(i));
  publisher.close();
}

TEST(Publisher, RecordsEachPairInTheOrderOfTheTable) {
  const test::TemporaryFolder folder;
  Publisher publisher({.images = ImageEncoding::kRaw, .tracks = true},
                      {.lcm_url = kNoBus, .record = folder.file("a")});
  publisher.publish(test::some_frame(0));
  Frame skipped = test::some_frame(1);
  skipped.pair.status = PairStatus::kSkipped;
  skipped.pair.left.resize(0, 0);
  skipped.pair.right.resize(0, 0);
  skipped.motion.status = EstimateStatus::kSkipped;
  skipped.objects.has_run = false;
  publisher.publish(skipped);
  publisher.close();
  const auto events = test::events_of(folder.file("a"));
  EXPECT_THAT(channels_of(events),
              ElementsAre("EGOMOD_CALIBRATION", "EGOMOD_POSE", "EGOMOD_VELOCITY", "EGOMOD_OBJECTS",
                          "EGOMOD_TRACKS", "EGOMOD_IMAGES", "EGOMOD_POSE", "EGOMOD_VELOCITY"));
  EXPECT_EQ(events.front().utime_us, 0);
  EXPECT_EQ(events.back().utime_us, 100'000);
}

TEST(Publisher, PassesOnWhatTheSourceHasEnclosedBehindItsOwn) {
  const test::TemporaryFolder folder;
  Publisher publisher({}, {.lcm_url = kNoBus, .record = folder.file("a"), .record_timing = true});
  Frame frame = test::some_frame(1);
  frame.pair.enclosed = {{"SIM_TRUTH_POSE", {1, 2, 3}}, {"SIM_TRUTH_OBJECTS", {4}}};
  publisher.publish(frame);
  publisher.close();
  const auto events = test::events_of(folder.file("a"));
  EXPECT_THAT(channels_of(events),
              ElementsAre("EGOMOD_CALIBRATION", "EGOMOD_POSE", "EGOMOD_VELOCITY", "EGOMOD_OBJECTS",
                          "EGOMOD_TIMING", "SIM_TRUTH_POSE", "SIM_TRUTH_OBJECTS"));
  EXPECT_EQ(events[5].bytes, "\x01\x02\x03");
  EXPECT_EQ(events[5].utime_us, 100'000);
}

TEST(Publisher, RecordsWhatTheBusHasAlreadyWithoutSendingItAgain) {
  const test::TemporaryFolder folder;
  {
    Publisher publisher({}, {.lcm_url = "file://" + folder.file("bus") + "?mode=w",
                             .record = folder.file("record")});
    Frame frame = test::some_frame(1);
    frame.pair.enclosed = {{"SIM_TRUTH_POSE", {1}}, {"PIONEER_ODOMETRY", {2}, false}};
    publisher.publish(frame);
    publisher.close();
  }
  EXPECT_EQ(channels_of(test::events_of(folder.file("record"))).back(), "PIONEER_ODOMETRY");
  EXPECT_EQ(channels_of(test::events_of(folder.file("bus"))).back(), "SIM_TRUTH_POSE");
}

TEST(Publisher, RepeatsTheCalibrationWhenItChanges) {
  const test::TemporaryFolder folder;
  Publisher publisher({}, {.lcm_url = kNoBus, .record = folder.file("a")});
  Frame frame = test::some_frame(0);
  publisher.publish(frame);
  publisher.publish(frame);
  frame.pair.calibration.camera.fx_px += 1;
  publisher.publish(frame);
  publisher.close();
  const auto channels = channels_of(test::events_of(folder.file("a")));
  EXPECT_EQ(std::count(channels.begin(), channels.end(), "EGOMOD_CALIBRATION"), 2);
}

TEST(Publisher, RepeatsTheCalibrationEachSecondToTheBusWhetherOrNotPairsCome) {
  const test::TemporaryFolder folder;
  {
    Publisher publisher({}, {.lcm_url = "file://" + folder.file("bus") + "?mode=w",
                             .record = folder.file("record"),
                             .live = true});
    publisher.repeat_calibration();
    publisher.publish(test::some_frame(0));
    publisher.repeat_calibration();
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    for (int i = 0; i < 3; ++i) publisher.repeat_calibration();
    publisher.close();
  }
  std::vector<std::string> calibrations;
  for (const test::Event& event : test::events_of(folder.file("bus"))) {
    if (event.channel == "EGOMOD_CALIBRATION") calibrations.push_back(event.bytes);
  }
  ASSERT_EQ(calibrations.size(), 2U);
  EXPECT_EQ(calibrations[0], calibrations[1]);
  const auto recorded = channels_of(test::events_of(folder.file("record")));
  EXPECT_EQ(std::count(recorded.begin(), recorded.end(), "EGOMOD_CALIBRATION"), 1);
}

TEST(Publisher, KeepsTimingOutOfTheRecordUnlessAskedAlsoWhenItGoesToTheBus) {
  const test::TemporaryFolder folder;
  for (const bool is_recorded : {false, true}) {
    Publisher publisher({}, {.lcm_url = "file://" + folder.file("bus") + "?mode=w",
                             .record = folder.file("record"),
                             .record_timing = is_recorded,
                             .live = true});
    publisher.publish(test::some_frame(0));
    publisher.close();
    const auto recorded = channels_of(test::events_of(folder.file("record")));
    EXPECT_EQ(std::count(recorded.begin(), recorded.end(), "EGOMOD_TIMING"), is_recorded ? 1 : 0);
  }
  const auto sent = channels_of(test::events_of(folder.file("bus")));
  EXPECT_EQ(std::count(sent.begin(), sent.end(), "EGOMOD_TIMING"), 1);
}

// The driver of raw cameras says that they are raw. What says the contrary beside it must publish
// rectified ones itself.
TEST(Publisher, CallsImagesRawWhenTheSourcesAreAndItPublishesNone) {
  for (const ImageEncoding images : {ImageEncoding::kNone, ImageEncoding::kRaw}) {
    for (const bool source_is_raw : {false, true}) {
      const test::TemporaryFolder folder;
      Publisher publisher({.images = images}, {.lcm_url = kNoBus, .record = folder.file("a")});
      Frame frame = test::some_frame(0);
      frame.pair.calibration.images_are_raw = source_is_raw;
      publisher.publish(frame);
      publisher.close();
      const std::string bytes = test::events_of(folder.file("a")).front().bytes;
      calibration_t message{};
      ASSERT_GT(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
      EXPECT_EQ(message.images_are_raw != 0, source_is_raw && images == ImageEncoding::kNone);
    }
  }
}

TEST(Publisher, GivesBusAndRecordTheSameBytes) {
  const test::TemporaryFolder folder;
  record(folder.file("record"), {.images = ImageEncoding::kJpeg, .tracks = true},
         "file://" + folder.file("bus") + "?mode=w");
  const auto on_bus = test::events_of(folder.file("bus"));
  const auto on_record = test::events_of(folder.file("record"));
  ASSERT_EQ(on_bus.size(), on_record.size());
  ASSERT_EQ(on_bus.size(), 1U + 3U * 5U);
  for (std::size_t i = 0; i < on_bus.size(); ++i) {
    EXPECT_EQ(on_bus[i].channel, on_record[i].channel);
    EXPECT_EQ(on_bus[i].bytes, on_record[i].bytes);
  }
}

TEST(Publisher, RecordsTheSamePairsToTheSameBytes) {
  const test::TemporaryFolder folder;
  record(folder.file("a"), {.images = ImageEncoding::kJpeg, .tracks = true});
  record(folder.file("b"), {.images = ImageEncoding::kJpeg, .tracks = true});
  EXPECT_FALSE(test::contents_of(folder.file("a")).empty());
  EXPECT_EQ(test::contents_of(folder.file("a")), test::contents_of(folder.file("b")));
}

TEST(Publisher, WarnsOnceOfAnAbsentBusAndGoesOn) {
  Publisher publisher({}, {.lcm_url = kNoBus});
  for (std::uint64_t i = 0; i < 3; ++i) publisher.publish(test::some_frame(i));
  publisher.close();
  EXPECT_THAT(publisher.take_warnings(), ElementsAre(HasSubstr("cannot be opened")));
  EXPECT_EQ(publisher.statistics().bus_errors, 10U);
}

TEST(Publisher, HoldsBackAndCountsWhatIsNotFinite) {
  const test::TemporaryFolder folder;
  Publisher publisher({}, {.lcm_url = kNoBus, .record = folder.file("a")});
  Frame frame = test::some_frame(1);
  frame.motion.T_previous_current.translation().x() = std::numeric_limits<double>::quiet_NaN();
  publisher.publish(frame);
  publisher.close();
  EXPECT_EQ(publisher.statistics().not_finite, 1U);
  EXPECT_THAT(channels_of(test::events_of(folder.file("a"))),
              ElementsAre("EGOMOD_CALIBRATION", "EGOMOD_POSE", "EGOMOD_OBJECTS"));
}

TEST(Publisher, RefusesARecordThatCannotBeOpened) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("missing/a.lcmlog");
  try {
    const Publisher publisher({}, {.lcm_url = kNoBus, .record = path});
    FAIL() << "no error";
  } catch (const RecordError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path));
    EXPECT_THAT(error.what(), HasSubstr("No such file"));
  }
}

TEST(Publisher, SaysThatTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  Publisher replay({.images = ImageEncoding::kRaw}, {.lcm_url = kNoBus, .record = "/dev/full"});
  EXPECT_THROW(
      {
        for (std::uint64_t i = 0; i < 10; ++i) replay.publish(test::some_frame(i));
        replay.close();
      },
      RecordError);
  try {
    replay.close();
    FAIL() << "the record is not whole";
  } catch (const RecordError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left")) << "the first reason, also later";
  }
}

TEST(Publisher, LiveGoesOnWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  Publisher live({.images = ImageEncoding::kRaw},
                 {.lcm_url = kNoBus, .record = "/dev/full", .live = true});
  for (std::uint64_t i = 0; i < 10; ++i) live.publish(test::some_frame(i));
  EXPECT_THAT(live.statistics().record_problem, HasSubstr("No space left"));
  EXPECT_THROW(live.close(), RecordError);
}

}  // namespace
}  // namespace egomod
