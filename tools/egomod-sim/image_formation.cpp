// SPDX-License-Identifier: Apache-2.0
#include "image_formation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "optics.hpp"

namespace egomod::sim {
namespace {

constexpr int kPhases = 256;
constexpr int kWeightBits = 11;
constexpr int kMargin_px = 3;  // cubic convolution takes one pixel before, two after
constexpr double kFinest = 1.5;

using Weights = std::array<std::int16_t, 4>;

// R. G. Keys, Cubic convolution interpolation for digital image processing (1981), a = -1/2.
double keys(double distance) {
  const double x = std::abs(distance);
  if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
  return x < 2.0 ? ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0 : 0.0;
}

std::array<Weights, kPhases> weight_table() {
  std::array<Weights, kPhases> table{};
  for (int phase = 0; phase < kPhases; ++phase) {
    const double at = static_cast<double>(phase) / kPhases;
    int left = 1 << kWeightBits;
    for (int tap : {0, 2, 3, 1}) {  // the second one takes what rounding leaves
      const int weight =
          tap == 1 ? left
                   : static_cast<int>(std::lround((1 << kWeightBits) * keys(at - (tap - 1))));
      left -= weight;
      table[static_cast<std::size_t>(phase)][static_cast<std::size_t>(tap)] =
          static_cast<std::int16_t>(weight);
    }
  }
  return table;
}

std::uint8_t mixed(const std::uint8_t* at, std::ptrdiff_t stride, const Weights& across,
                   const Weights& down) {
  int sum = 0;
  for (const std::int16_t weight : down) {
    const int row = at[0] * across[0] + at[1] * across[1] + at[2] * across[2] + at[3] * across[3];
    sum += ((row + 8) >> 4) * weight;
    at += stride;
  }
  const int grey = (sum + (1 << (2 * kWeightBits - 5))) >> (2 * kWeightBits - 4);
  return static_cast<std::uint8_t>(std::clamp(grey, 0, 255));
}

bool has_lens(const RawCamera& camera) {
  return std::ranges::any_of(camera.distortion, [](double k) { return k != 0.0; });
}

Pinhole pinhole_of(const RawCamera& c) {
  return {c.K(0, 0), c.K(1, 1), c.K(0, 2), c.K(1, 2), c.width_px, c.height_px};
}

// Neighbouring pixels' directions lie this far apart at the closest.
double finest_step(const std::vector<Eigen::Vector2d>& directions, int width_px) {
  double step = std::numeric_limits<double>::infinity();
  const auto width = static_cast<std::size_t>(width_px);
  for (std::size_t i = 0; i + width + 1 < directions.size(); ++i) {
    if ((i + 1) % width == 0) continue;
    step = std::min({step, (directions[i + 1] - directions[i]).norm(),
                     (directions[i + width] - directions[i]).norm()});
  }
  return step;
}

}  // namespace

ImageFormation::ImageFormation(const RawCamera& camera, const Shutter& shutter)
    : width_px_(camera.width_px), height_px_(camera.height_px), pinhole_(pinhole_of(camera)) {
  if (has_lens(camera)) see_through_lens(camera);
  lay_out_strips(camera.height_px, shutter);
  if (!places_.empty()) fill_sources();
}

void ImageFormation::see_through_lens(const RawCamera& camera) {
  const double f = camera.K(0, 0);
  std::vector<Eigen::Vector2d> directions;
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (int v = 0; v < height_px_; ++v) {
    for (int u = 0; u < width_px_; ++u) {
      const Eigen::Vector2d image((u - camera.K(0, 2)) / f, (v - camera.K(1, 2)) / f);
      directions.push_back(undistorted(camera.distortion, image).value());
      low = low.min(directions.back().array());
      high = high.max(directions.back().array());
    }
  }
  const double focal_px = std::min(kFinest * f, 1.0 / finest_step(directions, width_px_));
  const Eigen::Array2d size = ((high - low) * focal_px).ceil() + 2.0 * kMargin_px;
  const Eigen::Array2d centre = kMargin_px - low * focal_px;
  pinhole_ = {focal_px,
              focal_px,
              centre.x(),
              centre.y(),
              static_cast<int>(size.x()),
              static_cast<int>(size.y())};
  for (const Eigen::Vector2d& direction : directions) {
    places_.emplace_back(direction.array() * focal_px + centre);
  }
}

void ImageFormation::lay_out_strips(int height_px, const Shutter& shutter) {
  const int count = shutter.readout_s > 0.0 ? std::min(shutter.strips, height_px) : 1;
  const double middle = 0.5 * (height_px - 1);
  for (int i = 0; i < count; ++i) {
    Strip strip;
    strip.first_row = height_px * i / count;
    strip.end_row = height_px * (i + 1) / count;
    strip.offset_s =
        shutter.readout_s * (0.5 * (strip.first_row + strip.end_row - 1) - middle) / height_px;
    strip.first_view_row = strip.first_row;
    strip.end_view_row = strip.end_row;
    if (!places_.empty()) {
      const auto begin = places_.begin() + strip.first_row * width_px_;
      const auto end = places_.begin() + strip.end_row * width_px_;
      const auto [first, last] = std::minmax_element(
          begin, end, [](const auto& a, const auto& b) { return a.y() < b.y(); });
      strip.first_view_row = static_cast<int>(first->y()) - 1;
      strip.end_view_row =
          std::min(static_cast<int>(last->y()) + kMargin_px + 1, pinhole_.height_px);
    }
    strip.canvas_row = canvas_height_px_;
    canvas_height_px_ += strip.end_view_row - strip.first_view_row;
    strips_.push_back(strip);
  }
}

void ImageFormation::fill_sources() {
  const std::ptrdiff_t stride = Image(pinhole_.width_px, 1).stride_bytes();
  sources_.reserve(places_.size());
  for (const Strip& strip : strips_) {
    const int down = strip.canvas_row - strip.first_view_row;
    for (int i = strip.first_row * width_px_; i < strip.end_row * width_px_; ++i) {
      const Eigen::Array2d place = places_[static_cast<std::size_t>(i)].array();
      const Eigen::Array2i fixed = (place * kPhases).round().cast<int>();
      const Eigen::Array2i whole = fixed / kPhases;
      const Eigen::Array2i phase = fixed - whole * kPhases;
      sources_.push_back(
          {static_cast<std::int32_t>((whole.y() - 1 + down) * stride + whole.x() - 1),
           static_cast<std::uint8_t>(phase.x()), static_cast<std::uint8_t>(phase.y())});
    }
  }
}

void ImageFormation::develop(Image& canvas, Image& out) const {
  if (sources_.empty()) {
    std::swap(canvas, out);
    return;
  }
  const auto weights = weight_table();
  out.resize(width_px_, height_px_);
  const Source* source = sources_.data();
  for (int v = 0; v < height_px_; ++v) {
    std::uint8_t* row = out.row(v);
    for (int u = 0; u < width_px_; ++u, ++source) {
      row[u] = mixed(canvas.row(0) + source->offset, canvas.stride_bytes(),
                     weights[source->u_phase], weights[source->v_phase]);
    }
  }
}

}  // namespace egomod::sim
