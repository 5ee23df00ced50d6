// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/image_t.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "egomod/core/image.hpp"

namespace egomod::log {

// Decodes grey and JPEG images of the bus. Threads: one caller.
class PictureDecoder {
 public:
  PictureDecoder();
  // Throws std::runtime_error on any other format and on images that are damaged.
  void decode(const bot_core::image_t& message, Image& image);

 private:
  struct Free {
    void operator()(void* handle) const;
  };
  void decode_jpeg(const bot_core::image_t& message, Image& image);

  std::unique_ptr<void, Free> decompressor_;
};

// 8-bit BGR. Throws OutputError.
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace egomod::log
