// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "egomod/core/image.hpp"
#include "image_kernels.hpp"

namespace egomod {

// A square patch made ready for correlation.
template <int kSide>
class CorrelationPatch {
 public:
  // `stride` apart in memory; must lie inside the image.
  CorrelationPatch(const std::uint8_t* top_left, std::ptrdiff_t stride) {
    std::int32_t squares = 0;
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const std::int32_t value = top_left[j * stride + i];
        values_[static_cast<std::size_t>(j * kSide + i)] = static_cast<float>(value);
        sum_ += value;
        squares += value * value;
      }
    }
    variance_ = kSide * kSide * squares - sum_ * sum_;
  }

  [[nodiscard]] Correlation along(const float* strip, std::ptrdiff_t stride, int count) const {
    return {values_.data(), sum_, variance_, strip, stride, count};
  }

 private:
  std::array<float, static_cast<std::size_t>(kSide* kSide)> values_{};
  std::int32_t sum_ = 0;
  std::int32_t variance_ = 0;
};

// Copies `width` x `height` pixels as floats, rows `stride` apart and zeros behind them.
inline void copy_strip(const ImageView& image, int u, int v, int width, int height, float* strip,
                       std::ptrdiff_t stride) {
  for (int j = 0; j < height; ++j) {
    const std::uint8_t* const from = image.row(v + j) + u;
    float* const to = strip + j * stride;
    for (int i = 0; i < width; ++i) to[i] = static_cast<float>(from[i]);
    for (std::ptrdiff_t i = width; i < stride; ++i) to[i] = 0.0F;
  }
}

}  // namespace egomod
