// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "egomod/core/instruction_set.hpp"

namespace egomod {

// Zero-mean normalised cross-correlation of a square patch with `count` places along a strip.
// All values are whole numbers 0..255 in floats: sums of up to 121 products stay below 2^24, so
// that they are exact, and every instruction set gives the same bits.
struct Correlation {
  const float* patch = nullptr;  // side * side, row by row
  std::int32_t sum = 0;          // of the patch
  std::int32_t variance = 0;     // side^2 * sum of squares - sum^2
  const float* strip = nullptr;  // `side` rows, `stride` floats apart
  std::ptrdiff_t stride = 0;     // at least strip_stride(count, side)
  int count = 0;
};

// Sums over 7x7 pixels of products of Sobel gradients (8 times the gradient), and of the squared
// response of the noise mask (1 -2 1)x(1 -2 1).
struct WindowSums {
  std::int32_t xx = 0;
  std::int32_t xy = 0;
  std::int32_t yy = 0;
  std::int32_t noise = 0;
};

inline constexpr int kKernelBlock = 32;  // places or pixels that a kernel may write at once
[[nodiscard]] constexpr int padded_count(int count) {
  return (count + kKernelBlock - 1) / kKernelBlock * kKernelBlock;
}

// Rounded up to whole vectors.
[[nodiscard]] constexpr std::ptrdiff_t strip_stride(int count, int side) {
  return padded_count(count) + (side + 7) / 8 * 8;
}

struct ImageKernels {
  // One row at half resolution from four rows; `scratch` holds source_width + 2.
  void (*halve)(const std::uint8_t* const rows[4], int source_width, std::uint16_t* scratch,
                std::uint8_t* out);
  // Segment test: the largest t for which 9 contiguous pixels of the circle of radius 3 are all
  // more than t - 1 brighter (or all darker) than the centre; 0 unless above `threshold`. bright: 1
  // where the centre is the brighter. Reads and writes up to padded_count(count).
  void (*segment_contrast)(const std::uint8_t* centre, std::ptrdiff_t stride, int count,
                           int threshold, std::uint8_t* contrast, std::uint8_t* bright);
  // Keeps the local maxima of 3x3 that `blocked` does not veto, zero elsewhere; of equals the first
  // stays. Reads and writes up to padded_count(count).
  void (*peaks)(const std::uint8_t* contrast, std::ptrdiff_t stride, const std::uint8_t* blocked,
                int count, std::uint8_t* peaks);
  // Reads rows and columns -4..+5 around the centre.
  WindowSums (*window_sums)(const std::uint8_t* centre, std::ptrdiff_t stride);
  // Writes padded_count(count) values, those behind `count` without meaning; -1 where the strip is
  // flat.
  void (*correlate_8)(const Correlation& c, float* ncc);
  void (*correlate_11)(const Correlation& c, float* ncc);
  // Sums of absolute differences of 32 bytes: of one descriptor and `count` indexed ones.
  void (*descriptor_distances)(const std::uint8_t* one, const std::uint8_t* others,
                               std::ptrdiff_t stride_bytes, const std::int32_t* indices, int count,
                               std::int32_t* distances);
};

namespace baseline {
ImageKernels image_kernels();
}
namespace x86_64_v3 {
ImageKernels image_kernels();
}

[[nodiscard]] inline ImageKernels image_kernels() {
#if defined(EGOMOD_HAS_X86_64_V3)
  if (instruction_set() >= InstructionSet::kX86_64V3) return x86_64_v3::image_kernels();
#endif
  return baseline::image_kernels();
}

}  // namespace egomod
