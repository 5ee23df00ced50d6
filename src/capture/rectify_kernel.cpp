// SPDX-License-Identifier: Apache-2.0
#include "capture/rectify_kernel.hpp"

namespace egomod {
namespace {

constexpr int kHalf = 1 << (2 * kRectifyFractionBits - 1);

// clang has no shuffle by lanes that are not constants; it gets the pixels one by one.
#if !defined(__clang__)

using Bytes = std::uint8_t __attribute__((vector_size(16)));
using HalfBytes = std::uint8_t __attribute__((vector_size(8)));
using Shorts = std::int16_t __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(32)));

template <typename Vector>
Vector load(const void* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof(v));
  return v;
}

// Left neighbours in the lower half, right ones in the upper one.
Bytes both(HalfBytes lower, HalfBytes upper) {
  return __builtin_shufflevector(lower, upper, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14,
                                 15);
}

Shorts mix(Bytes left_and_right, Shorts to_right) {
  const auto left = __builtin_shufflevector(left_and_right, left_and_right, 0, 1, 2, 3, 4, 5, 6, 7);
  const auto right =
      __builtin_shufflevector(left_and_right, left_and_right, 8, 9, 10, 11, 12, 13, 14, 15);
  return __builtin_convertvector(left, Shorts) * (kRectifyOne - to_right) +
         __builtin_convertvector(right, Shorts) * to_right;
}

#endif

}  // namespace

std::uint8_t rectified_pixel(const std::uint8_t* upper, std::ptrdiff_t stride,
                             RectifyFraction fraction) {
  const std::uint8_t* lower = upper + stride;
  const int above = upper[0] * (kRectifyOne - fraction.u) + upper[1] * fraction.u;
  const int below = lower[0] * (kRectifyOne - fraction.u) + lower[1] * fraction.u;
  const int sum = above * (kRectifyOne - fraction.v) + below * fraction.v;
  return static_cast<std::uint8_t>((sum + kHalf) >> (2 * kRectifyFractionBits));
}

#if defined(__clang__)

void rectify_group(const std::uint8_t* window, std::ptrdiff_t stride, const RectifyGroup& group,
                   const RectifyFraction* fractions, std::uint8_t* to) {
  for (std::size_t k = 0; k < RectifyGroup::kPixels; ++k) {
    const std::ptrdiff_t row = group.is_lower[k] != 0 ? stride : 0;
    to[k] = rectified_pixel(window + row + group.column[k], stride, fractions[k]);
  }
}

#else

void rectify_group(const std::uint8_t* window, std::ptrdiff_t stride, const RectifyGroup& group,
                   const RectifyFraction* fractions, std::uint8_t* to) {
  const auto column = load<HalfBytes>(group.column.data());
  const auto is_lower = load<HalfBytes>(group.is_lower.data());
  const Bytes lanes = both(column, column + 1);
  const Bytes chosen = both(is_lower, is_lower);
  const Bytes first = __builtin_shuffle(load<Bytes>(window), lanes);
  const Bytes second = __builtin_shuffle(load<Bytes>(window + stride), lanes);
  const Bytes third = __builtin_shuffle(load<Bytes>(window + 2 * stride), lanes);
  const auto fraction = load<Shorts>(fractions);
  const Shorts to_right = fraction & 0xFF;
  const Shorts down = (fraction >> 8) & 0xFF;
  const Shorts above = mix((first & ~chosen) | (second & chosen), to_right);
  const Shorts below = mix((second & ~chosen) | (third & chosen), to_right);
  const Ints sum =
      __builtin_convertvector(above, Ints) * kRectifyOne +
      __builtin_convertvector(below - above, Ints) * __builtin_convertvector(down, Ints);
  const Ints grey = (sum + kHalf) >> (2 * kRectifyFractionBits);
  const auto bytes = __builtin_convertvector(__builtin_convertvector(grey, Shorts), HalfBytes);
  __builtin_memcpy(to, &bytes, sizeof(bytes));
}

#endif

}  // namespace egomod
