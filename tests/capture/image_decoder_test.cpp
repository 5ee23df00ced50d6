// SPDX-License-Identifier: Apache-2.0
#include "capture/image_decoder.hpp"

#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>
#include <random>
#include <vector>

namespace egomod {
namespace {

constexpr int kWidth_px = 38;
constexpr int kHeight_px = 9;
constexpr int kStride_bytes = 40;

class BayerTest : public ::testing::Test {
 protected:
  [[nodiscard]] int at(int u, int v) const {
    const auto mirrored = [](int x, int size) { return x < 0 ? 1 : x >= size ? size - 2 : x; };
    return mosaic_[static_cast<std::size_t>(mirrored(v, kHeight_px) * kStride_bytes +
                                            mirrored(u, kWidth_px))];
  }
  void decode() {
    const ImageRecord record{.width_px = kWidth_px,
                             .height_px = kHeight_px,
                             .row_stride_bytes = kStride_bytes,
                             .pixel_format = bot_core::image_t::PIXEL_FORMAT_BAYER_GRBG,
                             .size_bytes = static_cast<std::int32_t>(mosaic_.size())};
    ASSERT_TRUE(ImageDecoder().decode(record, mosaic_, {kWidth_px, kHeight_px}, grey_));
  }

  std::vector<std::uint8_t> mosaic_ = std::vector<std::uint8_t>(kStride_bytes * kHeight_px);
  Image grey_;
};

TEST_F(BayerTest, IsTheBinomialMeanOfThreeByThreeAlsoAtTheMirroredBorder) {
  std::minstd_rand random(1);
  for (std::uint8_t& byte : mosaic_) byte = static_cast<std::uint8_t>(random() >> 8U);
  decode();
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) {
      int sum = 8;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          sum += (2 - du * du) * (2 - dv * dv) * at(u + du, v + dv);
        }
      }
      ASSERT_EQ(grey_.row(v)[u], sum / 16) << u << ", " << v;
    }
  }
}

// Green 60, red 200, blue 100: 200/4 + 60/2 + 100/4.
TEST_F(BayerTest, OfOneColourIsOneGrey) {
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) {
      const int colour = (u + v) % 2 == 0 ? 60 : v % 2 == 0 ? 200 : 100;
      mosaic_[static_cast<std::size_t>(v * kStride_bytes + u)] = static_cast<std::uint8_t>(colour);
    }
  }
  decode();
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) ASSERT_EQ(grey_.row(v)[u], 105) << u << ", " << v;
  }
}

}  // namespace
}  // namespace egomod
