// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/image_t.hpp>
#include <cstdint>
#include <memory>

#include "egomod/core/image.hpp"
#include "egomod/publish/publish_config.hpp"

namespace egomod {

// Grey images as bot_core.image_t, raw or JPEG (which bot_core calls MJPEG). Buffers are kept.
// Threads: one caller.
class ImageEncoder {
 public:
  ImageEncoder(ImageEncoding encoding, int jpeg_quality);

  // Throws std::runtime_error when libjpeg-turbo refuses.
  void encode(const ImageView& image, std::int64_t utime_us, bot_core::image_t& message);

 private:
  struct Free {
    void operator()(void* handle) const;
    void operator()(std::uint8_t* buffer) const;
  };

  void encode_jpeg(const ImageView& image, bot_core::image_t& message);

  ImageEncoding encoding_;
  int jpeg_quality_;
  std::unique_ptr<void, Free> compressor_;  // null unless JPEG
  std::unique_ptr<std::uint8_t, Free> buffer_;
  unsigned long buffer_bytes_ = 0;
};

}  // namespace egomod
