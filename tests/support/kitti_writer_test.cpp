// SPDX-License-Identifier: Apache-2.0
#include "kitti_writer.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "scenes.hpp"

namespace egomod::test_support {
namespace {

namespace fs = std::filesystem;

class KittiWriter : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string text(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(folder_ / name).rdbuf();
    return out.str();
  }
  [[nodiscard]] static auto lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  }

  fs::path folder_ = fs::path(::testing::TempDir()) / ("kitti_writer_" + std::to_string(getpid()));
};

TEST_F(KittiWriter, WritesEveryFileOfTheLayout) {
  const SyntheticWorld world(crossing_robot(), kinect_pair(160));
  write_kitti_sequence(world, {.rate_hz = 10.0, .pairs = 3}, folder_);
  EXPECT_EQ(text("times.txt"), "0.000000\n0.100000\n0.200000\n");
  EXPECT_EQ(lines(text("poses.txt")), 3);
  EXPECT_EQ(lines(text("objects.csv")), 4);
  EXPECT_NE(text("objects.csv").find("frame,time,object_id,class,cx,cy,cz"), std::string::npos);
  EXPECT_NE(text("calib.txt").find("P1: 131.25 0 79.5 -49.21875 0 131.25 59.5 0"),
            std::string::npos);
  for (const char* eye : {"image_0", "image_1"}) {
    EXPECT_TRUE(fs::exists(folder_ / eye / "000002.png"));
    EXPECT_FALSE(fs::exists(folder_ / eye / "000003.png"));
  }
}

TEST_F(KittiWriter, PngHoldsThePixels) {
  fs::create_directories(folder_);
  Image image(37, 5);  // rows are padded in memory, never in the file
  for (int v = 0; v < 5; ++v) {
    for (int u = 0; u < 37; ++u) image.row(v)[u] = static_cast<std::uint8_t>(7 * u + v);
  }
  write_png(folder_ / "a.png", image.view());
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&png, (folder_ / "a.png").c_str()), 0);
  png.format = PNG_FORMAT_GRAY;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png));
  ASSERT_NE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr), 0);
  ASSERT_EQ(png.width, 37U);
  ASSERT_EQ(png.height, 5U);
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_TRUE(std::equal(&pixels[v * 37], &pixels[v * 37] + 37, image.row(static_cast<int>(v))));
  }
}

TEST_F(KittiWriter, UnwritableFileIsNamed) {
  const Image image(4, 4);
  try {
    write_png("/nowhere/a.png", image.view());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/a.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace egomod::test_support
