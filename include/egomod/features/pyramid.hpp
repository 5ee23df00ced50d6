// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "egomod/core/image.hpp"
#include "egomod/features/image_point.hpp"

namespace egomod {

// An image at full, half, quarter ... resolution. Each level is the one below it, low-passed with
// the binomial (1 3 3 1)/8 in both directions (edges repeated) and halved; an odd last row or
// column has no pixel of its own. The filter is even, so that the centre of a pixel of level k lies
// between the pixels of level k - 1, and
//   u_level = (u + 0.5) / 2^k - 0.5,   u = (u_level + 0.5) * 2^k - 0.5,   same for v.
// Level 0 is borrowed: the image must outlive its use here. Higher levels are owned and reused;
// only an image larger than all before allocates.
class Pyramid {
 public:
  static constexpr int kMaxLevels = 5;
  static constexpr int kMinSide_px = 16;  // no level gets smaller than this

  // Builds up to `levels` levels (1..kMaxLevels), fewer where the image is too small for them.
  void build(const ImageView& image, int levels);

  [[nodiscard]] int levels() const { return levels_; }
  [[nodiscard]] ImageView level(int k) const {
    return k == 0 ? base_ : owned_[static_cast<std::size_t>(k - 1)].view();
  }

 private:
  ImageView base_;
  int levels_ = 0;
  std::array<Image, kMaxLevels - 1> owned_;
  std::vector<std::uint16_t> scratch_;
};

[[nodiscard]] constexpr ImagePoint to_level(ImagePoint full, int level) {
  const float scale = 1.0F / static_cast<float>(1 << level);
  return {(full.u_px + 0.5F) * scale - 0.5F, (full.v_px + 0.5F) * scale - 0.5F};
}

}  // namespace egomod
