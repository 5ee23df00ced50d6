// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/capture/capture_config.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {

inline constexpr const char* kImagesChannel = "EGOMOD_IMAGES";
inline constexpr const char* kCalibrationChannel = "EGOMOD_CALIBRATION";

// Where `log` and `lcm` find images: `both` on one channel (bot_core.images_t), or left and right
// on channels of their own (bot_core.image_t). Unused names are empty. Throws SourceError.
struct ImageChannels {
  explicit ImageChannels(const CaptureConfig& config)
      : left(config.left_channel), right(config.right_channel) {
    if (left.empty() && right.empty()) {
      both = kImagesChannel;
    } else if (left.empty() || right.empty() || left == right) {
      throw SourceError(
          "capture.left_channel and capture.right_channel: give two different channels, or none "
          "of them to read EGOMOD_IMAGES");
    }
  }

  [[nodiscard]] std::string text() const { return both.empty() ? left + " and " + right : both; }

  std::string both;
  std::string left;
  std::string right;
};

}  // namespace egomod
