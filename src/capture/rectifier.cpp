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
  set_groups(raw);
}

void Rectifier::set_entry(std::size_t index, double u_px, double v_px, const RawCamera& raw) {
  const auto split = [](double position_px, int size_px) {
    const double inside = std::clamp(position_px, 0.0, size_px - 1.0);
    const auto fixed = static_cast<int>(std::lround(inside * kRectifyOne));
    const int whole = std::min(fixed / kRectifyOne, size_px - 2);
    return std::pair(whole, static_cast<std::uint8_t>(fixed - whole * kRectifyOne));
  };
  const auto [u, u_fraction] = split(u_px, raw.width_px);
  const auto [v, v_fraction] = split(v_px, raw.height_px);
  offsets_[index] = static_cast<std::int32_t>(v * stride_of(raw.width_px) + u);
  fractions_[index] = {u_fraction, v_fraction};
}

void Rectifier::set_groups(const RawCamera& raw) {
  groups_.reserve(offsets_.size() / RectifyGroup::kPixels);
  for (int v = 0; v < height_px_; ++v) {
    const std::int32_t* row = offsets_.data() + static_cast<std::ptrdiff_t>(v) * width_px_;
    for (int u = 0; u + RectifyGroup::kPixels <= width_px_; u += RectifyGroup::kPixels) {
      groups_.push_back(group_of(row + u, raw));
    }
  }
}

// No group where the neighbours are strewn too far, or the window would leave the raw image below.
RectifyGroup Rectifier::group_of(const std::int32_t* offsets, const RawCamera& raw) const {
  const auto stride = static_cast<std::int32_t>(stride_of(raw.width_px));
  int top = raw.height_px;
  int left = raw.width_px;
  for (int k = 0; k < RectifyGroup::kPixels; ++k) {
    top = std::min(top, offsets[k] / stride);
    left = std::min(left, offsets[k] % stride);
  }
  RectifyGroup group;
  for (std::size_t k = 0; k < RectifyGroup::kPixels; ++k) {
    const int row = offsets[k] / stride - top;
    const int column = offsets[k] % stride - left;
    if (row > RectifyGroup::kRows - 2 || column > RectifyGroup::kColumns - 2) return {};
    group.column[k] = static_cast<std::uint8_t>(column);
    group.is_lower[k] = row > 0 ? 255 : 0;
  }
  if (top + RectifyGroup::kRows <= raw.height_px) group.offset = top * stride + left;
  return group;
}

void Rectifier::apply(const Image& raw, Image& rectified) const {
  rectified.resize(width_px_, height_px_);
  const std::uint8_t* const from = raw.row(0);
  const std::ptrdiff_t stride = raw.stride_bytes();
  const RectifyGroup* group = groups_.data();
  for (int v = 0; v < height_px_; ++v) {
    const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(v) * width_px_;
    const std::int32_t* const offsets = offsets_.data() + begin;
    const RectifyFraction* const fractions = fractions_.data() + begin;
    std::uint8_t* const to = rectified.row(v);
    const auto one_by_one = [&](int first, int last) {
      for (int u = first; u < last; ++u)
        to[u] = rectified_pixel(from + offsets[u], stride, fractions[u]);
    };
    int u = 0;
    for (; u + RectifyGroup::kPixels <= width_px_; u += RectifyGroup::kPixels, ++group) {
      if (group->offset < 0) {
        one_by_one(u, u + RectifyGroup::kPixels);
      } else {
        rectify_group(from + group->offset, stride, *group, fractions + u, to + u);
      }
    }
    one_by_one(u, width_px_);
  }
}

}  // namespace egomod
