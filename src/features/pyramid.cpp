// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/pyramid.hpp"

#include <algorithm>

#include "image_kernels.hpp"

namespace egomod {
namespace {

void halve(const ImageKernels& kernels, const ImageView& fine, std::vector<std::uint16_t>& scratch,
           Image& coarse) {
  coarse.resize(fine.width_px / 2, fine.height_px / 2);
  for (int v = 0; v < coarse.height_px(); ++v) {
    const std::uint8_t* const rows[4] = {fine.row(std::max(2 * v - 1, 0)), fine.row(2 * v),
                                         fine.row(2 * v + 1),
                                         fine.row(std::min(2 * v + 2, fine.height_px - 1))};
    kernels.halve(rows, fine.width_px, scratch.data(), coarse.row(v));
  }
}

}  // namespace

void Pyramid::build(const ImageView& image, int levels) {
  const ImageKernels kernels = image_kernels();
  const auto scratch_size = static_cast<std::size_t>(image.width_px) + 2;
  if (scratch_.size() < scratch_size) scratch_.resize(scratch_size);
  base_ = image;
  levels_ = 1;
  for (int wanted = std::min(levels, kMaxLevels); levels_ < wanted; ++levels_) {
    const ImageView fine = level(levels_ - 1);
    if (std::min(fine.width_px, fine.height_px) / 2 < kMinSide_px) return;
    halve(kernels, fine, scratch_, owned_[static_cast<std::size_t>(levels_ - 1)]);
  }
}

}  // namespace egomod
