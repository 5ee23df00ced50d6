// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/rig_file.hpp"
#include "folder_fixture.hpp"

namespace egomod {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kRig = R"([rectified]
size_px = [40, 30]
fx_px = 100
fy_px = 100.0
cx_px = 20.0
cy_px = 15.0
baseline_m = 0.2
)";

class CalibrationSourcesTest : public TemporaryFolder {
 protected:
  std::string error_of_rig(const std::string& text) {
    write("rig.toml", text);
    try {
      static_cast<void>(read_rig_file(path("rig.toml")));
      return {};
    } catch (const SourceError& problem) {
      return problem.what();
    }
  }
};

TEST_F(CalibrationSourcesTest, RigFileOverridesTheFolder) {
  write_kitti(1);
  write("rig.toml", std::string(kRig) +
                        "[T_body_camera]\ntranslation_m = [0.1, 0, 0.3]\nrpy_rad = [0, 0, 0]\n");
  const auto source = open_source(spec(), {}, path("rig.toml"), "");
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.calibration.camera.fx_px, 100.0);
  EXPECT_EQ(pair.calibration.T_body_camera.translation(), Eigen::Vector3d(0.1, 0.0, 0.3));
  EXPECT_EQ(pair.calibration.T_body_camera.linear(), default_T_body_camera().linear());
}

TEST_F(CalibrationSourcesTest, RigFileErrorsNameLineAndKey) {
  EXPECT_EQ(error_of_rig(kRig), "");
  EXPECT_THAT(error_of_rig(std::string(kRig) + "focus = 1\n"),
              AllOf(HasSubstr("rig.toml:8"), HasSubstr("rectified.focus")));
  EXPECT_THAT(error_of_rig("[rectified]\nsize_px = [40]\n"),
              AllOf(HasSubstr("rig.toml:2"), HasSubstr("size_px")));
  EXPECT_THAT(error_of_rig("[rectified\n"), HasSubstr("rig.toml:1"));
  EXPECT_THAT(error_of_rig(""), HasSubstr("rectified is missing"));
}

std::string with(std::string text, const std::string& part, const std::string& replacement) {
  return text.replace(text.find(part), part.size(), replacement);
}

TEST_F(CalibrationSourcesTest, RigFileOfAbsurdValuesIsRefusedNamingLineAndKey) {
  const auto error_with = [&](const std::string& part, const std::string& replacement) {
    return error_of_rig(with(kRig, part, replacement));
  };
  EXPECT_EQ(error_with("cx_px = 20.0", "cx_px = 439"), "");
  EXPECT_EQ(error_with("fx_px = 100", "fx_px = 40000"), "");
  EXPECT_EQ(error_with("baseline_m = 0.2", "baseline_m = 100"), "");
  EXPECT_THAT(error_with("[40, 30]", "[40, 8]"),
              HasSubstr("rig.toml:2: rectified.size_px is not an image size"));
  EXPECT_THAT(error_with("fx_px = 100", "fx_px = 1e300"),
              HasSubstr("rig.toml:3: rectified.fx_px must be positive and at most 1000 times"));
  EXPECT_THAT(error_with("fy_px = 100.0", "fy_px = -100.0"),
              HasSubstr("rig.toml:4: rectified.fy_px must be positive"));
  EXPECT_THAT(error_with("cx_px = 20.0", "cx_px = 441"),
              HasSubstr("rig.toml:5: rectified.cx_px must lie within 10 image sizes"));
  EXPECT_THAT(error_with("cy_px = 15.0", "cy_px = -1e9"),
              HasSubstr("rig.toml:6: rectified.cy_px must lie within 10 image sizes"));
  for (const char* baseline : {"-0.2", "0", "101", "1e300"}) {
    EXPECT_THAT(error_with("baseline_m = 0.2", std::string("baseline_m = ") + baseline),
                HasSubstr("rig.toml:7: rectified.baseline_m must be positive and at most 100 m"));
  }
}

TEST_F(CalibrationSourcesTest, RigFileOfAbsurdRawCamerasIsRefusedNamingLineAndKey) {
  const std::string camera =
      "size_px = [40, 30]\nfx_px = 50\nfy_px = 50\ncx_px = 19.5\ncy_px = 14.5\n"
      "distortion = [-0.1, 0.01, 0, 0, 0]\n";
  const std::string rig = "[left]\n" + camera + "[right]\n" + camera +
                          "[right_from_left]\nrotation = [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
                          "translation_m = [-0.11, 0, 0]\n";
  const auto error_with = [&](const std::string& part, const std::string& replacement) {
    return error_of_rig(with(rig, part, replacement));
  };
  EXPECT_EQ(error_of_rig(rig), "");
  EXPECT_THAT(error_with("fx_px = 50", "fx_px = 1e300"),
              HasSubstr("rig.toml:3: left.fx_px must be positive and at most"));
  EXPECT_THAT(error_with("cx_px = 19.5", "cx_px = 1e9"),
              HasSubstr("rig.toml:5: left.cx_px must lie within 10 image sizes"));
  EXPECT_THAT(error_with("[-0.1, 0.01,", "[-0.1, 1001,"),
              HasSubstr("rig.toml:7: left.distortion must be coefficients of at most 1000"));
  EXPECT_THAT(error_with("rotation = [1, 0,", "rotation = [1, 0.1,"),
              HasSubstr("rig.toml:16: right_from_left.rotation is not a rotation"));
  EXPECT_THAT(error_with("rotation = [1,", "rotation = [-1,"), HasSubstr("is not a rotation"));
  EXPECT_THAT(error_with("[-0.11, 0, 0]", "[-110, 0, 0]"),
              AllOf(HasSubstr("rig.toml:17: right_from_left.translation_m"),
                    HasSubstr("must be positive and at most 100 m")));
}

TEST_F(CalibrationSourcesTest, KittiFolderOfAbsurdValuesIsRefusedNamingLineAndKey) {
  write_kitti(1);
  const auto error_of = [&](const std::string& K, const std::string& tx) {
    const auto row = [&](const std::string& t) { return with(K, "T", t) + " 0 0 0 1 0\n"; };
    write("calib.txt", "P0: " + row("0") + "P1: " + row(tx));
    return error_of_opening();
  };
  EXPECT_EQ(error_of("50 0 19.5 T 0 50 14.5", "-10"), "");
  EXPECT_THAT(
      error_of("1e300 0 19.5 T 0 50 14.5", "-10"),
      AllOf(HasSubstr("calib.txt:1: P0 and P1: focal lengths must be positive and at most")));
  EXPECT_THAT(error_of("50 0 1e9 T 0 50 14.5", "-10"),
              HasSubstr("calib.txt:1: P0 and P1: the principal point must lie within"));
  EXPECT_THAT(error_of("50 0 450 T 0 50 14.5", "-10"),
              AllOf(HasSubstr("calib.txt: cx must lie within 10 image sizes"),
                    HasSubstr("correct it, or name a rig file with --rig")));
  EXPECT_THAT(
      error_of("50 0 19.5 T 0 50 14.5", "-5500"),
      HasSubstr("calib.txt:1: P0 and P1: the baseline, 110.000000 m, must be positive and"));
}

TEST_F(CalibrationSourcesTest, RawFolderIsRectified) {
  write_kitti(1);
  std::string text;
  for (const std::string side : {"00", "01"}) {
    text += "S_" + side + ": 40 30\nK_" + side + ": 100 0 19 0 100 15 0 0 1\nD_" + side +
            ": 0 0 0 0 0\nR_rect_" + side + ": 1 0 0 0 1 0 0 0 1\nS_rect_" + side + ": 40 30\n";
  }
  text += "calib_time: 09-Jan-2012 13:57:47\nR_01: 1 0 0 0 1 0 0 0 1\nT_01: -0.2 0 0\n";
  text += "P_rect_00: 100 0 20 0 0 100 15 0 0 0 1 0\nP_rect_01: 100 0 20 -20 0 100 15 0 0 0 1 0\n";
  write("calib_full.txt", text);
  write_png("image_0/000000.png", kWidth_px, kHeight_px, [](int u, int) { return 5 * u; });
  const auto source = open_source(spec(), {}, "", "");
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_NEAR(pair.calibration.camera.baseline_m, 0.2, 1e-12);
  EXPECT_EQ(pair.left.row(10)[10], 45);  // one pixel to the right of where the raw camera saw it
  EXPECT_EQ(pair.left.row(10)[0], 0);
  write("calib_full.txt", text + "S_02: 1 2\nR_02: x\n");
  EXPECT_EQ(error_of_opening(), "");
  text.replace(text.find("40 30"), 5, "41 30");
  write("calib_full.txt", text);
  EXPECT_THAT(error_of_opening(), AllOf(HasSubstr("000000.png"), HasSubstr("41x30")));
}

class EurocTest : public CalibrationSourcesTest {
 protected:
  EurocTest() {
    for (const int camera : {0, 1}) {
      const std::string folder = "mav0/cam" + std::to_string(camera);
      write(folder + "/sensor.yaml", sensor(camera));
      write(folder + "/data.csv",
            "#timestamp [ns],filename\n1403636579763555584,a.png\r\n1403636579813555456,b.png\n");
      for (const char* name : {"a", "b"}) {
        write_png(folder + "/data/" + name + ".png", 40, 30, [](int, int) { return 77; });
      }
    }
  }
  static std::string sensor(int camera) {
    const std::string x = camera == 0 ? "0" : "0.11";
    return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + x +
           ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [40, 30]\n"
           "distortion_model: radial-tangential\nintrinsics: [50, 50, 19.5, 14.5]\n"
           "distortion_coefficients: [-0.1, 0.01, 0, 0]\n";
  }
  // Of the right camera's file with a part replaced.
  std::string error_with(const std::string& part, const std::string& replacement) {
    std::string text = sensor(1);
    text.replace(text.find(part), part.size(), replacement);
    write("mav0/cam1/sensor.yaml", text);
    return error_of_opening();
  }
};

TEST_F(EurocTest, RefusesWhatNoCameraCanBeNamingTheLine) {
  for (const char* size : {"[1e300, 30]", "[40.7, 30]", "[-40, 30]"}) {
    EXPECT_THAT(error_with("[40, 30]", size),
                HasSubstr("cam1/sensor.yaml:6: resolution: is not an image size"));
  }
  EXPECT_THAT(error_with("[50, 50,", "[50, -50,"),
              HasSubstr("cam1/sensor.yaml:8: intrinsics: focal lengths must be positive"));
  EXPECT_THAT(error_with("[50, 50,", "[1e300, 50,"),
              HasSubstr("cam1/sensor.yaml:8: intrinsics: focal lengths must be positive and at"));
  EXPECT_THAT(error_with("50, 19.5,", "50, 1e9,"),
              HasSubstr("cam1/sensor.yaml:8: intrinsics: the principal point must lie within"));
  EXPECT_THAT(error_with("[-0.1, 0.01,", "[-0.1, -1001,"),
              HasSubstr("cam1/sensor.yaml:9: distortion_coefficients: must be coefficients of"));
  EXPECT_THAT(error_with("0.11,", "110,"),
              AllOf(HasSubstr("cam1/sensor.yaml:3: T_BS: "), HasSubstr("at most 100 m")));
  EXPECT_THAT(error_with("data: [1, 0,", "data: [2, 0,"),
              HasSubstr("cam1/sensor.yaml:3: T_BS: is not a rigid transform"));
}

TEST_F(EurocTest, FolderIsPairedAndRectified) {
  const auto source = open_source(spec(), {}, "", "");
  EXPECT_EQ(source->size(), 2U);
  StereoPair pair;
  ASSERT_EQ(source->next(pair, {}), SourceState::kPair);
  EXPECT_EQ(pair.utime_us(), 1403636579763556);
  EXPECT_EQ(pair.status, PairStatus::kOk);
  EXPECT_NEAR(pair.calibration.camera.baseline_m, 0.11, 1e-12);
  EXPECT_EQ(pair.left.row(29)[39], 77);
  EXPECT_TRUE(pair.calibration.T_body_camera.isApprox(default_T_body_camera()));
  std::filesystem::remove(path("mav0/cam1/data/b.png"));
  EXPECT_THAT(error_of_opening(), AllOf(HasSubstr("data.csv:3"), HasSubstr("b.png")));
}

}  // namespace
}  // namespace egomod
