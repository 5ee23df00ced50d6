// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/image.hpp"

#include <gtest/gtest.h>

namespace egomod {
namespace {

TEST(Image, RowsAreAlignedAndKeepTheirPixels) {
  Image image(33, 5);
  for (int v = 0; v < 5; ++v) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.row(v)) % Image::kAlignmentBytes, 0U);
    for (int u = 0; u < 33; ++u) image.row(v)[u] = static_cast<std::uint8_t>(40 * v + u);
  }
  Image copy;
  copy_image(image.view(), copy);
  EXPECT_EQ(copy.row(4)[32], 192);
  EXPECT_EQ(copy.row(0)[0], 0);
}

TEST(Image, ShrinkingAndRegrowingKeepsTheBuffer) {
  Image image(640, 480);
  const std::uint8_t* before = image.row(0);
  image.resize(320, 240);
  image.resize(640, 480);
  EXPECT_EQ(image.row(0), before);
}

}  // namespace
}  // namespace egomod
