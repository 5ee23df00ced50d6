// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/image.hpp"

#include <cstring>
#include <new>

namespace egomod {

void Image::resize(int width_px, int height_px) {
  const auto width = static_cast<std::size_t>(width_px);
  const std::size_t stride = (width + kAlignmentBytes - 1) / kAlignmentBytes * kAlignmentBytes;
  const std::size_t bytes = stride * static_cast<std::size_t>(height_px) + kPaddingBytes;
  if (bytes > capacity_bytes_) {
    data_.reset(static_cast<std::uint8_t*>(std::aligned_alloc(kAlignmentBytes, bytes)));
    if (!data_) throw std::bad_alloc();
    std::memset(data_.get(), 0, bytes);
    capacity_bytes_ = bytes;
  }
  width_px_ = width_px;
  height_px_ = height_px;
  stride_bytes_ = static_cast<std::ptrdiff_t>(stride);
}

void copy_image(const ImageView& from, Image& to) {
  to.resize(from.width_px, from.height_px);
  for (int v = 0; v < from.height_px; ++v) {
    std::memcpy(to.row(v), from.row(v), static_cast<std::size_t>(from.width_px));
  }
}

}  // namespace egomod
