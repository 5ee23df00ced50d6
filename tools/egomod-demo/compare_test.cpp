// SPDX-License-Identifier: Apache-2.0
#include "compare.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>

namespace egomod::demo {
namespace {

namespace fs = std::filesystem;

class Compare : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(truth_);
    fs::create_directories(result_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

  fs::path folder_ = fs::path(::testing::TempDir()) / ("compare_" + std::to_string(getpid()));
  fs::path truth_ = folder_ / "truth";
  fs::path result_ = folder_ / "result";
};

constexpr const char* kStart = "1 0 0 0 0 1 0 0 0 0 1 0\n";

TEST_F(Compare, DriftIsTheDistanceAtTheEnd) {
  write(truth_ / "poses.txt", std::string(kStart) + "1 0 0 0 0 1 0 0 0 0 1 2\n");
  write(result_ / "poses.txt", std::string(kStart) + "1 0 0 0.03 0 1 0 0.04 0 0 1 2\n");
  const PathComparison path = compare_paths(truth_, result_);
  EXPECT_EQ(path.pairs, 2);
  EXPECT_DOUBLE_EQ(path.length_m, 2.0);
  EXPECT_NEAR(path.end_error_m, 0.05, 1e-12);
}

TEST_F(Compare, DriftIsNoShareOfAPathThatIsNone) {
  EXPECT_EQ(drift_text({.length_m = 2.0, .end_error_m = 0.05}), ": 2.50 % drift");
  EXPECT_EQ(drift_text({.length_m = 1e-9, .end_error_m = 0.05}), "");
}

TEST_F(Compare, MissingPosesAreAnError) {
  write(truth_ / "poses.txt", std::string(kStart) + kStart);
  write(result_ / "poses.txt", kStart);
  EXPECT_THROW((void)compare_paths(truth_, result_), std::runtime_error);
}

TEST_F(Compare, CountsFindsMissesAndStrays) {
  write(
      truth_ / "objects.csv",
      "frame,time,object_id,VX,VY,VZ,u_min,v_min,u_max,v_max,visible_px,occlusion_fraction,moving\n"
      "0,0.0,1,0.3,0,0.4,100,100,149,149,2500,0,1\n"
      "1,0.1,1,0.3,0,0.4,100,100,149,149,2500,0,1\n"
      "2,0.2,1,0.3,0,0.4,100,100,149,149,300,0,1\n"     // too small to be due
      "3,0.3,1,0.0,0,0.0,100,100,149,149,2500,0,0\n");  // at rest
  write(result_ / "objects.csv",
        "frame,time,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ,n_points\n"
        "1,0.1,7,110,100,159,149,0,0,3,0.6,0,0,9\n"
        "1,0.1,8,105,105,130,130,0,0,3,0.6,0,0,9\n"  // a second one on the same
        "2,0.2,7,100,100,149,149,0,0,3,0.6,0,0,9\n"
        "3,0.3,7,100,100,149,149,0,0,3,0.6,0,0,9\n");
  const ObjectsComparison result = compare_objects(truth_, result_);
  const ObjectComparison& object = result.objects.at(1);
  EXPECT_EQ(object.due, 2);
  EXPECT_EQ(object.found, 1);
  EXPECT_NEAR(object.first_seen_s, 0.1, 1e-12);
  EXPECT_NEAR(object.mean_speed_mps, 0.5, 1e-12);
  EXPECT_NEAR(object.speed_error_rms_mps, 0.1, 1e-12);
  EXPECT_EQ(result.estimates, 4);
  EXPECT_EQ(result.strays, 2);
}

TEST_F(Compare, LatenciesAreSortedPerStage) {
  EXPECT_TRUE(latencies(result_).empty());
  std::string csv = "frame,time,stage,ms\n";
  for (int i = 100; i >= 0; --i) csv += "0,0.0,features," + std::to_string(i) + "\n";
  write(result_ / "timing.csv", csv);
  const auto stages = latencies(result_);
  EXPECT_DOUBLE_EQ(stages.at("features").median_ms, 50.0);
  EXPECT_DOUBLE_EQ(stages.at("features").p99_ms, 99.0);
}

TEST_F(Compare, BrokenLinesAreNamed) {
  write(result_ / "timing.csv", "frame,time,stage,ms\n0,0.0,features,many\n");
  try {
    (void)latencies(result_);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("timing.csv:2: 'many'"), std::string::npos);
  }
}

}  // namespace
}  // namespace egomod::demo
