// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

#include <fmt/format.h>
#include <png.h>
#include <turbojpeg.h>

#include <cstddef>
#include <stdexcept>

#include "text_output.hpp"

namespace egomod::log {

void PictureDecoder::Free::operator()(void* handle) const { tjDestroy(handle); }

PictureDecoder::PictureDecoder() : decompressor_(tjInitDecompress()) {}

void PictureDecoder::decode(const bot_core::image_t& message, Image& image) {
  if (message.pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG) {
    decode_jpeg(message, image);
    return;
  }
  const bool fits = message.width > 0 && message.height > 0 &&
                    message.row_stride >= message.width &&
                    message.data.size() / static_cast<std::size_t>(message.row_stride) >=
                        static_cast<std::size_t>(message.height);
  if (message.pixelformat != bot_core::image_t::PIXEL_FORMAT_GRAY || !fits) {
    throw std::runtime_error(
        fmt::format("image at {} us: pixel format {} or its size is not usable", message.utime,
                    message.pixelformat));
  }
  copy_image({message.data.data(), message.width, message.height, message.row_stride}, image);
}

void PictureDecoder::decode_jpeg(const bot_core::image_t& message, Image& image) {
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colours = 0;
  const auto size = static_cast<unsigned long>(message.data.size());
  tjhandle handle = decompressor_.get();
  bool ok = tjDecompressHeader3(handle, message.data.data(), size, &width, &height, &subsampling,
                                &colours) == 0;
  if (ok) {
    image.resize(width, height);
    ok = tjDecompress2(handle, message.data.data(), size, image.row(0), width,
                       static_cast<int>(image.stride_bytes()), height, TJPF_GRAY, 0) == 0;
  }
  if (ok) return;
  throw std::runtime_error(
      fmt::format("image at {} us: JPEG: {}", message.utime, tjGetErrorStr2(handle)));
}

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(picture.cols);
  header.height = static_cast<png_uint_32>(picture.rows);
  header.format = PNG_FORMAT_BGR;
  header.flags = PNG_IMAGE_FLAG_FAST;
  const auto stride = static_cast<png_int_32>(picture.step[0]);
  if (png_image_write_to_file(&header, file.c_str(), 0, picture.data, stride, nullptr) == 0) {
    throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), &header.message[0]));
  }
}

}  // namespace egomod::log
