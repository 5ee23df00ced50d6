// SPDX-License-Identifier: Apache-2.0
#include "folder_fixture.hpp"

#include <png.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace egomod {
namespace {

void write_pixels(const std::string& file, int width_px, int height_px, int colour_type, int depth,
                  const std::vector<std::uint8_t>& bytes) {
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (stream == nullptr) throw std::runtime_error("cannot write " + file);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, stream);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width_px), static_cast<png_uint_32>(height_px),
               depth, colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const std::size_t row_bytes = bytes.size() / static_cast<std::size_t>(height_px);
  for (std::size_t v = 0; v < static_cast<std::size_t>(height_px); ++v) {
    png_write_row(png, bytes.data() + v * row_bytes);
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(stream);
}

std::string index_name(int index) {
  std::ostringstream text;
  text << std::setw(6) << std::setfill('0') << index << ".png";
  return text.str();
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "egomod-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
  folder_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void TemporaryFolder::write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name) << text;
}

void TemporaryFolder::write_png(const std::string& name, int width_px, int height_px,
                                const std::function<int(int, int)>& grey) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::vector<std::uint8_t> bytes;
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) bytes.push_back(static_cast<std::uint8_t>(grey(u, v)));
  }
  write_pixels(path(name), width_px, height_px, PNG_COLOR_TYPE_GRAY, 8, bytes);
}

void TemporaryFolder::write_rgb_png(const std::string& name, int width_px, int height_px, int red,
                                    int green, int blue) const {
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < width_px * height_px; ++i) {
    for (const int value : {red, green, blue}) bytes.push_back(static_cast<std::uint8_t>(value));
  }
  write_pixels(path(name), width_px, height_px, PNG_COLOR_TYPE_RGB, 8, bytes);
}

void TemporaryFolder::write_png16(const std::string& name, int width_px, int height_px,
                                  int value) const {
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < width_px * height_px; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  }
  write_pixels(path(name), width_px, height_px, PNG_COLOR_TYPE_GRAY, 16, bytes);
}

void TemporaryFolder::write_times(const std::string& name, int count, double interval_s,
                                  double offset_s) const {
  std::ostringstream text;
  text << std::fixed << std::setprecision(9);
  for (int i = 0; i < count; ++i) text << offset_s + i * interval_s << "\n";
  write(name, text.str());
}

void TemporaryFolder::write_kitti(int images, double interval_s) const {
  for (int i = 0; i < images; ++i) {
    write_png("image_0/" + index_name(i), kWidth_px, kHeight_px, [i](int, int) { return 10 * i; });
    write_png("image_1/" + index_name(i), kWidth_px, kHeight_px,
              [i](int, int) { return 10 * i + 5; });
  }
  write(
      "calib.txt",
      "P0: 525 0 320.6 0 0 525 238.7 0 0 0 1 0\nP1: 525 0 320.6 -196.875 0 525 238.7 0 0 0 1 0\n");
  write_times("times.txt", images, interval_s, 0.0);
}

std::string TemporaryFolder::error_of_opening(const CaptureConfig& config,
                                              const std::string& rig_file) const {
  try {
    static_cast<void>(open_source(spec(), config, rig_file, ""));
    return {};
  } catch (const SourceError& problem) {
    return problem.what();
  }
}

}  // namespace egomod
