// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/images_t.hpp>
#include <cstdint>
#include <egomod/calibration_t.hpp>
#include <egomod/odometry_t.hpp>
#include <string>
#include <vector>

namespace egomod {

inline constexpr int kMessageWidth_px = 32;
inline constexpr int kMessageHeight_px = 24;

// All pixels of one grey.
[[nodiscard]] bot_core::image_t grey_image(std::int64_t utime_us, int grey);
[[nodiscard]] bot_core::image_t jpeg_image(std::int64_t utime_us, int grey);
[[nodiscard]] bot_core::images_t stereo(const bot_core::image_t& left,
                                        const bot_core::image_t& right);
[[nodiscard]] calibration_t rectified_calibration(double fx_px = 100.0);

[[nodiscard]] odometry_t odometry_at(std::int64_t utime_us, std::int64_t sequence, double x_m);

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace egomod
