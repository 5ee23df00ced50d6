// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/image_encoder.hpp"

#include <turbojpeg.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace egomod {
namespace {

void copy_rows(const ImageView& image, std::vector<std::uint8_t>& data) {
  const auto width = static_cast<std::size_t>(image.width_px);
  data.resize(width * static_cast<std::size_t>(image.height_px));
  for (int v = 0; v < image.height_px; ++v) {
    std::memcpy(data.data() + static_cast<std::size_t>(v) * width, image.row(v), width);
  }
}

}  // namespace

void ImageEncoder::Free::operator()(void* handle) const { tjDestroy(handle); }
void ImageEncoder::Free::operator()(std::uint8_t* buffer) const { tjFree(buffer); }

ImageEncoder::ImageEncoder(ImageEncoding encoding, int jpeg_quality)
    : encoding_(encoding), jpeg_quality_(jpeg_quality) {
  if (encoding_ != ImageEncoding::kJpeg) return;
  compressor_.reset(tjInitCompress());
  if (!compressor_) throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(nullptr));
}

void ImageEncoder::encode(const ImageView& image, std::int64_t utime_us,
                          bot_core::image_t& message) {
  message.utime = utime_us;
  message.width = image.width_px;
  message.height = image.height_px;
  message.nmetadata = 0;
  message.metadata.clear();
  if (encoding_ == ImageEncoding::kJpeg) {
    encode_jpeg(image, message);
  } else {
    message.row_stride = image.width_px;
    message.pixelformat = bot_core::image_t::PIXEL_FORMAT_GRAY;
    copy_rows(image, message.data);
  }
  message.size = static_cast<std::int32_t>(message.data.size());
}

void ImageEncoder::encode_jpeg(const ImageView& image, bot_core::image_t& message) {
  const unsigned long bound = tjBufSize(image.width_px, image.height_px, TJSAMP_GRAY);
  if (bound > buffer_bytes_) {
    buffer_.reset(tjAlloc(static_cast<int>(bound)));
    buffer_bytes_ = buffer_ ? bound : 0;
    if (!buffer_) throw std::runtime_error("JPEG: out of memory");
  }
  std::uint8_t* to = buffer_.get();
  unsigned long size = buffer_bytes_;
  if (tjCompress2(compressor_.get(), image.data, image.width_px,
                  static_cast<int>(image.stride_bytes), image.height_px, TJPF_GRAY, &to, &size,
                  TJSAMP_GRAY, jpeg_quality_, TJFLAG_NOREALLOC) != 0) {
    throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(compressor_.get()));
  }
  message.row_stride = 0;
  message.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  message.data.assign(to, to + size);
}

}  // namespace egomod
