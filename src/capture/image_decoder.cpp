// SPDX-License-Identifier: Apache-2.0
#include "capture/image_decoder.hpp"

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <csetjmp>
#include <cstdio>
#include <cstring>

// After <cstdio>: jpeglib.h needs FILE and size_t.
#include <jpeglib.h>

#include "capture/grey.hpp"

namespace egomod {
namespace {

using bot_core::image_t;

// Bytes a pixel of an uncompressed format; 0 for others.
int bytes_per_pixel(std::int32_t pixel_format) {
  switch (pixel_format) {
    case image_t::PIXEL_FORMAT_GRAY:
    case image_t::PIXEL_FORMAT_BAYER_GRBG:
    case image_t::PIXEL_FORMAT_BAYER_RGGB:
      return 1;
    case image_t::PIXEL_FORMAT_RGB:
    case image_t::PIXEL_FORMAT_BGR:
      return 3;
    default:
      return 0;
  }
}

struct JpegErrors {
  jpeg_error_mgr manager{};
  std::jmp_buf escape{};
};

[[noreturn]] void on_jpeg_error(j_common_ptr info) {
  std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->escape, 1);
}

void on_jpeg_message(j_common_ptr) {}

void grey_from_colour(const std::uint8_t* from, int width_px, int red, std::uint8_t* to) {
  for (int u = 0; u < width_px; ++u, from += 3) to[u] = luma(from[red], from[1], from[2 - red]);
}

// 1 2 1 across and down over the mosaic: everywhere R/4 + G/2 + B/4, without a shift. The border
// repeats mirrored, which keeps the colours of the mosaic in step. `sums` are the columns' of a
// row, from one before the first to one behind the last; plain loops over them become vectors.
void grey_from_bayer(std::span<const std::uint8_t> data, std::ptrdiff_t stride, Image& to,
                     std::vector<std::uint16_t>& sums) {
  const auto width = static_cast<std::size_t>(to.width_px());
  const int height = to.height_px();
  sums.resize(width + 2);
  for (int v = 0; v < height; ++v) {
    const std::uint8_t* above = data.data() + (v == 0 ? 1 : v - 1) * stride;
    const std::uint8_t* here = data.data() + v * stride;
    const std::uint8_t* below = data.data() + (v == height - 1 ? height - 2 : v + 1) * stride;
    std::uint16_t* const sum = sums.data() + 1;
    for (std::size_t u = 0; u < width; ++u) {
      sum[u] = static_cast<std::uint16_t>(above[u] + 2 * here[u] + below[u]);
    }
    sums.front() = sum[1];
    sums.back() = sum[width - 2];
    const std::uint16_t* const before = sums.data();
    std::uint8_t* const grey = to.row(v);
    for (std::size_t u = 0; u < width; ++u) {
      const auto all =
          static_cast<std::uint16_t>(before[u] + 2 * before[u + 1] + before[u + 2] + 8);
      grey[u] = static_cast<std::uint8_t>(all >> 4U);
    }
  }
}

bool decode_plain(const ImageRecord& record, std::span<const std::uint8_t> data, Image& to,
                  std::vector<std::uint16_t>& sums) {
  const std::ptrdiff_t pixel_bytes = bytes_per_pixel(record.pixel_format);
  const std::ptrdiff_t row_bytes = pixel_bytes * record.width_px;
  const std::ptrdiff_t stride = record.row_stride_bytes;
  const std::ptrdiff_t needed = stride * (record.height_px - 1) + row_bytes;
  if (stride < row_bytes || static_cast<std::ptrdiff_t>(data.size()) < needed) return false;
  to.resize(record.width_px, record.height_px);
  if (record.pixel_format == image_t::PIXEL_FORMAT_BAYER_GRBG ||
      record.pixel_format == image_t::PIXEL_FORMAT_BAYER_RGGB) {
    grey_from_bayer(data, stride, to, sums);
    return true;
  }
  const int red = record.pixel_format == image_t::PIXEL_FORMAT_BGR ? 2 : 0;
  for (int v = 0; v < record.height_px; ++v) {
    const std::uint8_t* from = data.data() + v * stride;
    if (pixel_bytes == 1) {
      std::memcpy(to.row(v), from, static_cast<std::size_t>(row_bytes));
    } else {
      grey_from_colour(from, record.width_px, red, to.row(v));
    }
  }
  return true;
}

}  // namespace

struct ImageDecoder::Jpeg {
  Jpeg() {
    info.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = on_jpeg_error;
    errors.manager.output_message = on_jpeg_message;
    if (setjmp(errors.escape) == 0) jpeg_create_decompress(&info);
  }
  ~Jpeg() { jpeg_destroy_decompress(&info); }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;

  // libjpeg jumps out of here: nothing in it needs a destructor.
  bool decode(std::span<const std::uint8_t> data, ImageSize expected, Image& to) {
    if (setjmp(errors.escape) != 0) {
      jpeg_abort_decompress(&info);
      return false;
    }
    jpeg_mem_src(&info, data.data(), static_cast<unsigned long>(data.size()));
    jpeg_read_header(&info, TRUE);
    info.out_color_space = JCS_GRAYSCALE;
    info.dct_method = JDCT_ISLOW;
    const bool fits = info.image_width == static_cast<JDIMENSION>(expected.width_px) &&
                      info.image_height == static_cast<JDIMENSION>(expected.height_px);
    if (!fits) {
      jpeg_abort_decompress(&info);
      return false;
    }
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      JSAMPROW row = to.row(static_cast<int>(info.output_scanline));
      jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
    // libjpeg only warns of missing or corrupt data, and fills the rest in with grey.
    return errors.manager.num_warnings == 0;
  }

  jpeg_decompress_struct info{};
  JpegErrors errors;
};

bool is_supported(std::int32_t pixel_format) {
  return pixel_format == image_t::PIXEL_FORMAT_MJPEG || bytes_per_pixel(pixel_format) != 0;
}

ImageDecoder::ImageDecoder() : jpeg_(std::make_unique<Jpeg>()) {}
ImageDecoder::~ImageDecoder() = default;

bool ImageDecoder::decode(const ImageRecord& record, std::span<const std::uint8_t> data,
                          ImageSize expected, Image& to) {
  if (ImageSize{record.width_px, record.height_px} != expected) return false;
  if (record.pixel_format != image_t::PIXEL_FORMAT_MJPEG) {
    return bytes_per_pixel(record.pixel_format) != 0 && decode_plain(record, data, to, sums_);
  }
  to.resize(expected.width_px, expected.height_px);
  return !data.empty() && jpeg_->decode(data, expected, to);
}

}  // namespace egomod
