// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bot_core/images_t.hpp>
#include <cmath>
#include <cstring>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <sstream>

#include "egomod/capture/frame_source.hpp"
#include "small_world.hpp"

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kExact = 1e-6;

std::string contents(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

std::map<std::string, std::string> tree(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[fs::relative(entry.path(), folder)] = contents(entry.path());
    }
  }
  return files;
}

class RecorderTest : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  RecordingSummary record_world(const World& world, const std::string& name) const {
    Simulator simulator(world);
    return record(simulator, {path(name), path(name + ".lcmlog"), {.depth = true, .masks = true}});
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("egomod_recorder_" + std::to_string(getpid()));
};

World shortened(const std::string& text, double duration_s) {
  World world = test::world_of(text);
  world.duration_s = duration_s;
  return world;
}

TEST_F(RecorderTest, SameSeedSameBytesWithEveryKnobOn) {
  World world = shortened(test::unreal_room(), 0.4);
  record_world(world, "a");
  record_world(world, "b");
  const auto a = tree(folder_ / "a");
  EXPECT_GT(a.size(), 30U);
  EXPECT_TRUE(a == tree(folder_ / "b"));
  EXPECT_TRUE(contents(path("a.lcmlog")) == contents(path("b.lcmlog")));
  world.seed = 6;
  record_world(world, "c");
  EXPECT_FALSE(contents(path("a/image_0/000000.png")) == contents(path("c/image_0/000000.png")));
}

TEST_F(RecorderTest, FolderAndLogReplayTheSamePairs) {
  const auto summary = record_world(test::world_of(test::unreal_room()), "world");
  EXPECT_LT(summary.left_images, 30);  // some got lost
  const auto folder = open_source("folder:" + path("world"), {}, "", "");
  const auto log = open_source("log:" + path("world.lcmlog"), {}, "", "");
  ASSERT_EQ(folder->size(), static_cast<std::uint64_t>(summary.left_images));
  ASSERT_EQ(log->size(), folder->size());
  StereoPair a;
  StereoPair b;
  double largest_skew_s = 0.0;
  while (folder->next(a, {}) == SourceState::kPair) {
    ASSERT_EQ(log->next(b, {}), SourceState::kPair);
    ASSERT_EQ(a.exposure, b.exposure);
    ASSERT_EQ(a.status, b.status);
    ASSERT_TRUE(a.calibration == b.calibration);
    if (a.status != PairStatus::kOk) continue;
    ASSERT_EQ(a.right_exposure, b.right_exposure);
    largest_skew_s = std::max(largest_skew_s, 1e-9 * static_cast<double>(a.skew().count()));
    for (int v = 0; v < a.left.height_px(); ++v) {
      ASSERT_EQ(std::memcmp(a.left.row(v), b.left.row(v), 160), 0);
      ASSERT_EQ(std::memcmp(a.right.row(v), b.right.row(v), 160), 0);
    }
  }
  EXPECT_NEAR(largest_skew_s, 0.0065, 0.004);
}

TEST_F(RecorderTest, OnlyWhatIsNotIdealGetsFilesOfItsOwn) {
  record_world(shortened(test::unreal_room(), 0.2), "world");
  EXPECT_TRUE(fs::exists(path("world/calib_full.txt")));
  EXPECT_TRUE(fs::exists(path("world/times_right.txt")));
  record_world(shortened(test::small_room(), 0.1), "world");
  EXPECT_FALSE(fs::exists(path("world/calib_full.txt")));
  EXPECT_FALSE(fs::exists(path("world/times_right.txt")));
  EXPECT_FALSE(fs::exists(path("world/image_0/000003.png")));
  EXPECT_EQ(open_source("folder:" + path("world"), {}, "", "")->size(), 3U);
}

struct LoggedEvent {
  std::string channel;
  std::int64_t timestamp_us;
  std::vector<std::uint8_t> bytes;

  template <typename Message>
  [[nodiscard]] Message as() const {
    Message message;
    EXPECT_GT(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
    return message;
  }
};

std::vector<LoggedEvent> events_of(const std::string& log, const std::string& channel = "") {
  lcm::LogFile file(log, "r");
  std::vector<LoggedEvent> events;
  while (const lcm::LogEvent* event = file.readNextEvent()) {
    if (!channel.empty() && event->channel != channel) continue;
    const auto* bytes = static_cast<const std::uint8_t*>(event->data);
    events.push_back({event->channel, event->timestamp, {bytes, bytes + event->datalen}});
  }
  return events;
}

TEST_F(RecorderTest, LateImagesAreLoggedLateAndKeepTheirExposure) {
  World world = shortened(test::small_room(), 0.7);
  world.timing.late_probability = 0.3;
  world.timing.late_s = 0.05;
  record_world(world, "world");
  std::int64_t last_us = 0;
  int late = 0;
  for (const LoggedEvent& event : events_of(path("world.lcmlog"))) {
    EXPECT_GE(event.timestamp_us, last_us);
    last_us = event.timestamp_us;
    if (event.channel != "EGOMOD_IMAGES") continue;
    const auto images = event.as<bot_core::images_t>();
    ASSERT_EQ(images.n_images, 1);
    const std::int64_t delay_us = event.timestamp_us - images.images[0].utime;
    EXPECT_TRUE(delay_us == 0 || delay_us == 50000);
    late += delay_us == 50000 ? 1 : 0;
  }
  EXPECT_NEAR(late, 0.3 * 42, 8.0);
}

TEST_F(RecorderTest, TruthIsOnItsChannelsInBodyAndWorldFrame) {
  record_world(shortened(test::small_room(), 0.5), "world");
  const auto poses = events_of(path("world.lcmlog"), "SIM_TRUTH_POSE");
  const auto objects = events_of(path("world.lcmlog"), "SIM_TRUTH_OBJECTS");
  ASSERT_EQ(poses.size(), 15U);
  ASSERT_EQ(objects.size(), 15U);
  const auto pose = poses[12].as<truth_pose_t>();
  EXPECT_EQ(pose.utime, 400000);
  EXPECT_EQ(pose.sequence, 12);
  // A circle to the right: forward is x, right is negative y, right turns are negative about z.
  const double turn = 10.0 * M_PI / 180.0;
  const double radius_m = 0.3 / turn;
  const double turned = 0.4 * turn;
  EXPECT_NEAR(pose.pos[0], radius_m * std::sin(turned), kExact);
  EXPECT_NEAR(pose.pos[1], -radius_m * (1.0 - std::cos(turned)), kExact);
  EXPECT_NEAR(pose.pos[2], 0.0, kExact);
  EXPECT_NEAR(pose.orientation[0], std::cos(0.5 * turned), kExact);
  EXPECT_NEAR(pose.orientation[3], -std::sin(0.5 * turned), kExact);
  EXPECT_NEAR(pose.vel[0], 0.3, kExact);
  EXPECT_NEAR(pose.vel[1], 0.0, kExact);
  EXPECT_NEAR(pose.rotation_rate[2], -turn, kExact);
  const auto list = objects[12].as<truth_object_list_t>();
  EXPECT_EQ(list.utime, 400000);
  EXPECT_EQ(list.sequence, 12);
  ASSERT_EQ(list.n_objects, 2);
  const truth_object_t& robot = list.objects[0];
  EXPECT_EQ(robot.id, 1);
  // It drives to the right of the first pose: along negative y of the world.
  EXPECT_NEAR(robot.vel[0], 0.0, kExact);
  EXPECT_NEAR(robot.vel[1], -0.5, kExact);
  EXPECT_NEAR(robot.body_vel[0], 0.5 * std::sin(turned), kExact);
  EXPECT_NEAR(robot.body_vel[1], -0.5 * std::cos(turned), kExact);
  // Body and world position are the same point.
  const Eigen::Quaterniond q(pose.orientation[0], pose.orientation[1], pose.orientation[2],
                             pose.orientation[3]);
  const Vector3d P = q * Vector3d::Map(robot.body_pos) + Vector3d::Map(pose.pos);
  EXPECT_NEAR((P - Vector3d::Map(robot.pos)).norm(), 0.0, kExact);
  EXPECT_NEAR(robot.pos[0], 1.8 - 0.22, 0.15);  // the side that is seen
  EXPECT_NEAR(robot.extent[1], 0.75, kExact);
  EXPECT_GT(robot.visible, 100);
  EXPECT_LT(robot.u_min, robot.u_max);
  EXPECT_NE(robot.moving, 0);
}

TEST_F(RecorderTest, ObjectsHaveTheVelocityOfTheirCentreInTheTable) {
  record_world(shortened(test::small_room(), 0.05), "world");
  std::istringstream csv(contents(path("world/objects.csv")));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "frame,time,object_id,class,cx,cy,cz,bx,by,bz,VX,VY,VZ,wx,wy,wz,"
            "u_min,v_min,u_max,v_max,visible_px,occlusion_fraction,moving");
  std::getline(csv, line);
  EXPECT_THAT(line, HasSubstr("0,0.000000,1,pioneer,"));
  EXPECT_THAT(line, HasSubstr(",0.50000,0.00000,0.00000,"));
  std::getline(csv, line);
  EXPECT_THAT(line, HasSubstr("0,0.000000,2,box,"));
  // It turns on the spot, to the right: about y, which points down.
  EXPECT_THAT(line, testing::ContainsRegex(",-?0.00000,-?0.00000,-?0.00000,-?0.00000,1.04720,"));
}

}  // namespace
}  // namespace egomod::sim
