// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "capture/image_message.hpp"
#include "capture/pair_preparer.hpp"
#include "egomod/core/image.hpp"

namespace egomod {

[[nodiscard]] bool is_supported(std::int32_t pixel_format);

// Turns the pixels of image messages into 8-bit grey: GRAY, RGB, BGR, Bayer GRBG and RGGB, MJPEG.
// Colour becomes the luma of BT.601; of a Bayer mosaic each pixel becomes R/4 + G/2 + B/4 of its
// 3x3 neighbourhood. Threads: one caller.
class ImageDecoder {
 public:
  ImageDecoder();
  ~ImageDecoder();
  ImageDecoder(const ImageDecoder&) = delete;
  ImageDecoder& operator=(const ImageDecoder&) = delete;

  // False, with `to` undefined, for an image that is damaged, unsupported or not of `expected`
  // size. `data` are the record's `size_bytes`.
  [[nodiscard]] bool decode(const ImageRecord& record, std::span<const std::uint8_t> data,
                            ImageSize expected, Image& to);

 private:
  struct Jpeg;
  std::unique_ptr<Jpeg> jpeg_;
  std::vector<std::uint16_t> sums_;  // of a mosaic's row
};

}  // namespace egomod
