// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "evaluation.hpp"
#include "html.hpp"
#include "json.hpp"
#include "sequence.hpp"
#include "tables.hpp"
#include "temporary_folder.hpp"

namespace egomod::eval {
namespace {

using ::testing::HasSubstr;

constexpr const char* kIdentity = "1 0 0 0 0 1 0 0 0 0 1 0\n";

class Files : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() + "/" + name) << text;
    return folder_.path() + "/" + name;
  }
  static std::string error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(Files, AMalformedPoseNamesFileAndLine) {
  const std::string file = write("poses.txt", std::string(kIdentity) + "1 2 3\n");
  EXPECT_THAT(error_of([&] {
                static_cast<void>(read_poses(file, PoseFormat::kKitti, {0, 1}));
              }),
              HasSubstr("poses.txt:2: 3 numbers"));
  const std::string words = write("poses.txt", "1 0 0 zero\n");
  EXPECT_THAT(error_of([&] {
                static_cast<void>(read_poses(words, PoseFormat::kKitti, {0, 1}));
              }),
              HasSubstr("poses.txt:1: 'zero' is not a number"));
}

TEST_F(Files, AMalformedCellNamesFileLineAndColumn) {
  write("objects.csv",
        "frame,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ\n"
        "# comment\n0,1,2,3,x,5,1,1,1,0,0,0\n");
  EXPECT_THAT(error_of([&] { static_cast<void>(read_result(folder_.path())); }),
              HasSubstr("objects.csv:3: column 'u_max': 'x' is not a finite number"));
  write("objects.csv", "frame,track_id\n");
  EXPECT_THAT(error_of([&] { static_cast<void>(read_result(folder_.path())); }),
              HasSubstr("objects.csv:1: the header has no column 'u_min'"));
}

TEST_F(Files, WhatIsNotThereIsNamed) {
  EXPECT_THAT(error_of([&] { static_cast<void>(read_truth(folder_.path() + "/none")); }),
              HasSubstr("/none: is no folder"));
  EXPECT_THAT(error_of([&] { static_cast<void>(read_truth(folder_.path())); }),
              HasSubstr("times.txt: cannot be read"));
  EXPECT_THAT(error_of([&] { static_cast<void>(read_record(folder_.path() + "/no.lcmlog")); }),
              HasSubstr("no.lcmlog: cannot be opened"));
}

TEST_F(Files, ALogThatIsNoneIsRefused) {
  const std::string log = write("bad.lcmlog", "this is no log of events at all, only some text");
  EXPECT_THAT(error_of([&] { static_cast<void>(read_record(log)); }), HasSubstr("bad.lcmlog"));
}

// Half a turn about y, and frames by time.
TEST_F(Files, TumPosesFindTheirFramesByTime) {
  const std::string file = write(
      "poses.tum", "# t x y z q\n10.01 1 2 3 0 1 0 0\n10.49 4 5 6 0 0 0 1\n99 0 0 0 0 0 0 1\n");
  const Poses poses = read_poses(file, PoseFormat::kTum, {10.0, 10.25, 10.5});
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].frame, 0);
  EXPECT_EQ(poses[1].frame, 2);
  EXPECT_NEAR(poses[0].T_world_camera.linear()(0, 0), -1.0, 1e-12);
  EXPECT_NEAR(poses[1].T_world_camera.translation().z(), 6.0, 1e-12);
}

TEST_F(Files, TumPosesOfAnotherTimeAreRefused) {
  const std::string file = write("poses.tum", "99 0 0 0 0 0 0 1\n");
  EXPECT_THAT(error_of([&] {
                static_cast<void>(read_poses(file, PoseFormat::kTum, {0, 1}));
              }),
              HasSubstr("none of its timestamps"));
}

TEST_F(Files, ReportsHoldTheFiguresOfAllRuns) {
  write("times.txt", "0\n0.1\n");
  const std::string file = write("poses.txt", std::string(kIdentity) + kIdentity);
  const eval::Run run{.name = "a<b",
                      .truth = folder_.path(),
                      .estimate = file,
                      .kind = EstimateKind::kPoses,
                      .format = PoseFormat::kKitti,
                      .method = ""};
  const Evaluation evaluation = evaluate(run, {});
  EXPECT_THAT(json_of({evaluation}), HasSubstr("\"path_m\": 0"));
  const std::string html = html_report({evaluation, evaluation}).text;
  EXPECT_THAT(html, HasSubstr("a&lt;b"));
  EXPECT_THAT(html, HasSubstr("Overview"));
}

}  // namespace
}  // namespace egomod::eval
