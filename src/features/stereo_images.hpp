// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/core/stereo_pair.hpp"
#include "egomod/features/pyramid.hpp"

namespace egomod {

// Both images of a pair with their pyramids, kept beyond the life of the pair's own slot.
struct StereoImages {
  Image left_image;
  Image right_image;
  Pyramid left;
  Pyramid right;

  void take(const StereoPair& pair) {
    copy_image(pair.left.view(), left_image);
    copy_image(pair.right.view(), right_image);
    left.build(left_image.view(), kLevels);
    right.build(right_image.view(), kLevels);
  }

  static constexpr int kLevels = 3;
};

}  // namespace egomod
