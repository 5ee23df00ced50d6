// SPDX-License-Identifier: Apache-2.0
#include "record_truth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>

#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/messages.hpp"
#include "egomod/publish/record_writer.hpp"
#include "temporary_folder.hpp"

namespace egomod::eval {
namespace {

using ::testing::HasSubstr;

constexpr double kExact = 1e-9;

// A record of nothing but truth.
class RecordTruth : public ::testing::Test {
 protected:
  template <typename Message>
  void write(const std::string& channel, const Message& message) {
    record_.write({channel, message.utime, encode_message(message, buffer_)});
  }
  // The rig is at x, forward, and looks that way.
  void write_pose(std::int64_t sequence, std::int64_t utime, double x) {
    truth_pose_t pose{};
    pose.sequence = sequence;
    pose.utime = utime;
    pose.pos[0] = x;
    pose.orientation[0] = 1.0;
    write("SIM_TRUTH_POSE", pose);
  }
  Truth truth() {
    record_.flush();
    return read_truth_of_record(log_);
  }
  std::string error() {
    try {
      static_cast<void>(truth());
    } catch (const std::exception& problem) {
      return problem.what();
    }
    return "none";
  }

  TemporaryFolder folder_;
  std::string log_ = folder_.path() + "/drive.lcmlog";
  RecordWriter record_{log_};
  std::vector<std::uint8_t> buffer_;
};

TEST_F(RecordTruth, IsThatOfTheLeftCamera) {
  Calibration calibration;
  calibration.camera = {.fx_px = 500.0, .fy_px = 500.0, .baseline_m = 0.4};
  calibration_t message{};
  fill_message(calibration, false, message);
  write("EGOMOD_CALIBRATION", message);
  write_pose(0, 0, 0.0);
  write_pose(1, 33'333, 0.25);
  truth_object_list_t list{.utime = 33'333, .sequence = 1, .n_objects = 1, .objects = {{}}};
  truth_object_t& object = list.objects[0];
  object = {.id = 7,
            .pos = {},
            .vel = {},
            .body_pos = {5.0, 1.0, -0.5},
            .body_vel = {0.1, 0.2, 0.0},
            .extent = {0.4, 0.7, 0.6},
            .u_min = 10,
            .v_min = 20,
            .u_max = 30,
            .v_max = 40,
            .visible = 441,
            .moving = 1};
  write("SIM_TRUTH_OBJECTS", list);
  const Truth read = truth();
  EXPECT_EQ(read.name, "drive");
  EXPECT_EQ(read.focal_px, 500.0);
  EXPECT_EQ(read.baseline_m, 0.4);
  EXPECT_EQ(read.times_s, (std::vector<double>{0.0, 0.033333}));
  ASSERT_EQ(read.poses.size(), 2U);
  EXPECT_NEAR(read.poses[1].T_world_camera.translation().z(), 0.25, kExact);
  ASSERT_TRUE(read.objects);
  const TruthObject& seen = read.objects->at(1).at(0);
  EXPECT_EQ(seen.id, "7");
  EXPECT_NEAR((seen.surface_m - Eigen::Vector3d(-1.0, 0.5, 5.0)).norm(), 0.0, kExact);
  EXPECT_NEAR((seen.velocity_mps - Eigen::Vector3d(-0.2, 0.0, 0.1)).norm(), 0.0, kExact);
  EXPECT_NEAR(seen.centre_m.z(), 5.3, kExact);
  EXPECT_EQ(seen.visible_px, 441);
  EXPECT_TRUE(seen.moving);
  EXPECT_TRUE(seen.rectangle.contains(30.0, 40.0));
}

TEST_F(RecordTruth, GivesFramesThatWereDroppedTheirTime) {
  write_pose(2, 200'000, 0.0);
  write_pose(4, 400'000, 0.0);
  write_pose(5, 600'000, 0.0);
  const Truth read = truth();
  const std::vector<double> expected{0.0, 0.1, 0.2, 0.3, 0.4, 0.6};
  ASSERT_EQ(read.times_s.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(read.times_s[i], expected[i], kExact) << i;
  }
  EXPECT_EQ(read.poses[1].frame, 4);
}

TEST_F(RecordTruth, RefusesARecordWithoutAndOneThatRunsBackwards) {
  EXPECT_THAT(error(), HasSubstr("drive.lcmlog: holds no truth, as a record of --source sim does"));
  write_pose(1, 100'000, 0.0);
  write_pose(1, 200'000, 0.0);
  EXPECT_THAT(error(), HasSubstr("drive.lcmlog: SIM_TRUTH_POSE: sequences must ascend from 0"));
}

}  // namespace
}  // namespace egomod::eval
