// SPDX-License-Identifier: Apache-2.0
#include "capture/rectifier.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/lens.hpp"

namespace egomod {
namespace {

constexpr double kBehind = 1e-6;  // a ray this flat or flatter never meets the raw image

std::ptrdiff_t stride_of(int width_px) { return Image(width_px, 1).stride_bytes(); }

}  // namespace

Rectifier::Rectifier(const RawCamera& raw, const StereoCamera& rectified)
    : width_px_(rectified.width_px), height_px_(rectified.height_px) {
  const auto pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  offsets_.resize(pixels);
  fractions_.resize(pixels);
  const Lens lens(raw);
  const Eigen::Matrix3d R_raw_rectified = raw.R_rectified_raw.transpose();
  std::size_t index = 0;
  for (int v = 0; v < height_px_; ++v) {
    for (int u = 0; u < width_px_; ++u, ++index) {
      const Eigen::Vector3d ray((u - rectified.cx_px) / rectified.fx_px,
                                (v - rectified.cy_px) / rectified.fy_px, 1.0);
      const Eigen::Vector3d x = R_raw_rectified * ray;
      const Eigen::Vector2d pixel = lens.pixel(x.head<2>() / std::max(x.z(), kBehind));
      set_entry(index, pixel.x(), pixel.y(), raw);
    }
  }
}

void Rectifier::set_entry(std::size_t index, double u_px, double v_px, const RawCamera& raw) {
  constexpr int kOne = 1 << kFractionBits;
  const auto split = [](double position_px, int size_px) {
    const double inside = std::clamp(position_px, 0.0, size_px - 1.0);
    const auto fixed = static_cast<int>(std::lround(inside * kOne));
    const int whole = std::min(fixed / kOne, size_px - 2);
    return std::pair(whole, fixed - whole * kOne);
  };
  const auto [u, u_fraction] = split(u_px, raw.width_px);
  const auto [v, v_fraction] = split(v_px, raw.height_px);
  offsets_[index] = static_cast<std::int32_t>(v * stride_of(raw.width_px) + u);
  fractions_[index] = static_cast<std::uint16_t>(u_fraction | v_fraction << 8);
}

void Rectifier::apply(const Image& raw, Image& rectified) const {
  constexpr std::uint32_t kOne = 1U << kFractionBits;
  constexpr std::uint32_t kHalf = 1U << (2 * kFractionBits - 1);
  rectified.resize(width_px_, height_px_);
  const std::uint8_t* const upper = raw.row(0);
  const std::uint8_t* const lower = raw.row(1);
  const std::int32_t* offset = offsets_.data();
  const std::uint16_t* fraction = fractions_.data();
  for (int v = 0; v < height_px_; ++v) {
    std::uint8_t* to = rectified.row(v);
    for (int u = 0; u < width_px_; ++u, ++offset, ++fraction) {
      // Upper row in the low half word, lower row in the high one: one multiplication for both.
      const std::uint8_t* a = upper + *offset;
      const std::uint8_t* b = lower + *offset;
      const std::uint32_t near = a[0] | static_cast<std::uint32_t>(b[0]) << 16;
      const std::uint32_t far = a[1] | static_cast<std::uint32_t>(b[1]) << 16;
      const std::uint32_t fu = *fraction & 0xFFU;
      const std::uint32_t fv = *fraction >> 8;
      const std::uint32_t mixed = near * (kOne - fu) + far * fu;
      const std::uint32_t sum = (mixed & 0xFFFFU) * (kOne - fv) + (mixed >> 16) * fv;
      to[u] = static_cast<std::uint8_t>((sum + kHalf) >> (2 * kFractionBits));
    }
  }
}

}  // namespace egomod
