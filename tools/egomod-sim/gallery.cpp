// SPDX-License-Identifier: Apache-2.0
#include "gallery.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "kitti_writer.hpp"
#include "simulator.hpp"
#include "world_file.hpp"

namespace egomod::sim {
namespace {

constexpr int kColumns = 5;
constexpr int kWidth_px = 256;
constexpr int kHeight_px = 192;
constexpr int kCaption_px = 20;
constexpr int kGap_px = 4;
constexpr double kBackground = 250.0;

cv::Mat picture_of(const std::filesystem::path& file) {
  Simulator simulator(read_world(file));
  const World& world = simulator.world();
  Image image;
  simulator.take_image(Eye::kLeft,
                       static_cast<std::uint64_t>(0.5 * world.duration_s * world.rate_hz), image);
  const cv::Mat whole(image.height_px(), image.width_px(), CV_8UC1, image.row(0),
                      static_cast<std::size_t>(image.stride_bytes()));
  cv::Mat small;
  cv::resize(whole, small, {kWidth_px, kHeight_px}, 0.0, 0.0, cv::INTER_AREA);
  return small;
}

void place(const cv::Mat& picture, const std::string& name, int index, cv::Mat& sheet) {
  const int x = kGap_px + index % kColumns * (kWidth_px + kGap_px);
  const int y = kGap_px + index / kColumns * (kHeight_px + kCaption_px + kGap_px);
  picture.copyTo(sheet(cv::Rect(x, y, kWidth_px, kHeight_px)));
  cv::putText(sheet, name, {x + 2, y + kHeight_px + kCaption_px - 6}, cv::FONT_HERSHEY_SIMPLEX,
              0.45, 0.0, 1, cv::LINE_AA);
}

}  // namespace

void write_gallery(const std::filesystem::path& worlds, const std::filesystem::path& file) {
  const std::vector<std::string> names = worlds_in(worlds);
  const int rows = (static_cast<int>(names.size()) + kColumns - 1) / kColumns;
  cv::Mat sheet(kGap_px + rows * (kHeight_px + kCaption_px + kGap_px),
                kGap_px + kColumns * (kWidth_px + kGap_px), CV_8UC1, cv::Scalar(kBackground));
  for (std::size_t i = 0; i < names.size(); ++i) {
    place(picture_of(find_world(names[i], worlds)), names[i], static_cast<int>(i), sheet);
  }
  test_support::write_png(
      file, {sheet.data, sheet.cols, sheet.rows, static_cast<std::ptrdiff_t>(sheet.step[0])});
}

}  // namespace egomod::sim
