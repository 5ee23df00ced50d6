// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/image.hpp"
#include "egomod/features/image_point.hpp"

namespace egomod {

inline constexpr int kSearchPatch_px = 8;

// 8x8 grey values, row by row; its centre lies between the pixels 3 and 4 of both directions.
using SearchPatch = std::array<std::uint8_t, kSearchPatch_px * kSearchPatch_px>;

struct PatchSearchResult {
  bool found = false;      // false: no texture, or no position inside the image
  PixelPosition top_left;  // of the best place; its centre is 3.5 px further right and down
  float ncc = -1.0F;
  float second_ncc = -1.0F;  // best place more than 2 px away from it, -1 without any
};

// Top left pixel of the patch whose centre is nearest to `centre`.
[[nodiscard]] PixelPosition patch_top_left(ImagePoint centre);

// Copies the patch at `top_left`; false where it leaves the image.
[[nodiscard]] bool copy_patch(const ImageView& image, PixelPosition top_left, SearchPatch& patch);

// Looks for small patches around predicted positions of one pyramid level by zero-mean normalised
// cross-correlation at every whole pixel within +-radius in both directions.
// Threads: one caller.
class PatchSearch {
 public:
  static constexpr int kMaxRadius_px = 32;

  PatchSearch();

  [[nodiscard]] PatchSearchResult search(const ImageView& image, const SearchPatch& patch,
                                         PixelPosition predicted_top_left, int radius_px);

 private:
  std::vector<float> strip_;
  std::vector<float> ncc_;
};

}  // namespace egomod
