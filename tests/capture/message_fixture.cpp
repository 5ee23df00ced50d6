// SPDX-License-Identifier: Apache-2.0
#include "message_fixture.hpp"

#include <cstdio>
#include <cstdlib>

// After <cstdio>: jpeglib.h needs FILE and size_t.
#include <jpeglib.h>

namespace egomod {
namespace {

bot_core::image_t empty_image(std::int64_t utime_us, int pixel_format) {
  bot_core::image_t image;
  image.utime = utime_us;
  image.width = kMessageWidth_px;
  image.height = kMessageHeight_px;
  image.row_stride = kMessageWidth_px;
  image.pixelformat = pixel_format;
  image.nmetadata = 0;
  return image;
}

}  // namespace

bot_core::image_t grey_image(std::int64_t utime_us, int grey) {
  bot_core::image_t image = empty_image(utime_us, bot_core::image_t::PIXEL_FORMAT_GRAY);
  image.data.assign(kMessageWidth_px * kMessageHeight_px, static_cast<std::uint8_t>(grey));
  image.size = static_cast<std::int32_t>(image.data.size());
  return image;
}

bot_core::image_t jpeg_image(std::int64_t utime_us, int grey) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = kMessageWidth_px;
  info.image_height = kMessageHeight_px;
  info.input_components = 1;
  info.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&info);
  jpeg_start_compress(&info, TRUE);
  std::vector<std::uint8_t> row(kMessageWidth_px, static_cast<std::uint8_t>(grey));
  for (int v = 0; v < kMessageHeight_px; ++v) {
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&info, &pointer, 1);
  }
  jpeg_finish_compress(&info);
  bot_core::image_t image = empty_image(utime_us, bot_core::image_t::PIXEL_FORMAT_MJPEG);
  image.row_stride = 0;
  image.data.assign(bytes, bytes + size);
  image.size = static_cast<std::int32_t>(image.data.size());
  jpeg_destroy_compress(&info);
  std::free(bytes);
  return image;
}

bot_core::images_t stereo(const bot_core::image_t& left, const bot_core::image_t& right) {
  bot_core::images_t message;
  message.utime = left.utime;
  message.n_images = 2;
  message.image_types = {bot_core::images_t::LEFT, bot_core::images_t::RIGHT};
  message.images = {left, right};
  return message;
}

calibration_t rectified_calibration(double fx_px) {
  calibration_t message{};
  message.width = kMessageWidth_px;
  message.height = kMessageHeight_px;
  message.fx = fx_px;
  message.fy = fx_px;
  message.cx = 15.5;
  message.cy = 11.5;
  message.baseline = 0.2;
  for (const int i : {2, 4, 9}) message.T_body_camera[i] = i == 2 ? 1.0 : -1.0;
  return message;
}

odometry_t odometry_at(std::int64_t utime_us, std::int64_t sequence, double x_m) {
  odometry_t message{};
  message.utime = utime_us;
  message.sequence = sequence;
  message.x = x_m;
  return message;
}

}  // namespace egomod
