// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>

namespace egomod {

// A borrowed 8-bit grey image. Pixel centres lie on integers; rows are `stride_bytes` apart.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;

  [[nodiscard]] bool empty() const { return data == nullptr || width_px <= 0 || height_px <= 0; }
  [[nodiscard]] const std::uint8_t* row(int v) const { return data + v * stride_bytes; }
};

// An owned 8-bit grey image, rows aligned to 64 bytes. `resize` allocates only when it must grow,
// so that a slot that has seen its largest image never allocates again. The bytes behind the last
// row are padded with `kPaddingBytes`, so that kernels may read (never use) a vector past the end.
class Image {
 public:
  static constexpr std::size_t kAlignmentBytes = 64;
  static constexpr std::size_t kPaddingBytes = 64;

  Image() = default;
  Image(int width_px, int height_px) { resize(width_px, height_px); }

  void resize(int width_px, int height_px);

  [[nodiscard]] bool empty() const { return width_px_ == 0 || height_px_ == 0; }
  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  [[nodiscard]] std::ptrdiff_t stride_bytes() const { return stride_bytes_; }
  [[nodiscard]] std::uint8_t* row(int v) { return data_.get() + v * stride_bytes_; }
  [[nodiscard]] const std::uint8_t* row(int v) const { return data_.get() + v * stride_bytes_; }
  [[nodiscard]] ImageView view() const {
    return {data_.get(), width_px_, height_px_, stride_bytes_};
  }

 private:
  struct Free {
    void operator()(std::uint8_t* p) const { std::free(p); }
  };
  std::unique_ptr<std::uint8_t, Free> data_;
  std::size_t capacity_bytes_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  std::ptrdiff_t stride_bytes_ = 0;
};

// Copies pixels; `to` takes the size of `from`.
void copy_image(const ImageView& from, Image& to);

}  // namespace egomod
