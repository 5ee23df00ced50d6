// SPDX-License-Identifier: Apache-2.0
#include "pixel_truth.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tables.hpp"

namespace egomod::eval {
namespace {

namespace fs = std::filesystem;

struct Size {
  int width_px;
  int height_px;
};

template <typename Pixel>
Size read_png(const fs::path& file, png_uint_32 format, std::vector<Pixel>& pixels) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, file.c_str()) == 0) {
    throw InputError(fmt::format("{}: {}", file.string(), png.message));
  }
  png.format = format;
  pixels.resize(PNG_IMAGE_SIZE(png) / sizeof(Pixel));
  if (png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr) == 0) {
    throw InputError(fmt::format("{}: {}", file.string(), png.message));
  }
  return {static_cast<int>(png.width), static_cast<int>(png.height)};
}

bool is_near(double depth_m, double truth_m) {
  return std::abs(depth_m - truth_m) <= depth_slack_m(truth_m);
}

}  // namespace

std::optional<PixelTruth> PixelTruth::open(const fs::path& truth) {
  if (!fs::is_directory(truth / "mask_0")) return std::nullopt;
  return PixelTruth(truth, fs::is_directory(truth / "depth_0"));
}

void PixelTruth::load(int frame) {
  if (frame == frame_) return;
  const std::string name = fmt::format("{:06d}.png", frame);
  const Size size = read_png(folder_ / "mask_0" / name, PNG_FORMAT_GRAY, ids_);
  width_px_ = size.width_px;
  height_px_ = size.height_px;
  depth_mm_.assign(ids_.size(), 0);
  if (has_depth_) {
    const fs::path file = folder_ / "depth_0" / name;
    const Size other = read_png(file, PNG_FORMAT_LINEAR_Y, depth_mm_);
    if (other.width_px != width_px_ || other.height_px != height_px_) {
      throw InputError(file.string() + ": has not the size of the mask");
    }
  }
  frame_ = frame;
}

// Inverse depth is linear on a plane.
std::optional<double> PixelTruth::resting_depth_at(int frame, double u_px, double v_px) {
  constexpr double kMostStep = 0.02;  // of the inverse depth, from pixel to pixel: an edge
  load(frame);
  const int u = static_cast<int>(std::floor(u_px));
  const int v = static_cast<int>(std::floor(v_px));
  if (u < 0 || v < 0 || u + 1 >= width_px_ || v + 1 >= height_px_) return std::nullopt;
  double least = 1e9, most = 0.0, sum = 0.0;
  for (int y = v; y <= v + 1; ++y) {
    for (int x = u; x <= u + 1; ++x) {
      const auto i = static_cast<std::size_t>(y * width_px_ + x);
      if (ids_[i] != 0 || depth_mm_[i] == 0) return std::nullopt;
      const double inverse = 1e3 / depth_mm_[i];
      least = std::min(least, inverse);
      most = std::max(most, inverse);
      sum += inverse * (1.0 - std::abs(u_px - x)) * (1.0 - std::abs(v_px - y));
    }
  }
  return most > (1.0 + kMostStep) * least ? std::nullopt : std::optional(1.0 / sum);
}

std::optional<int> PixelTruth::object_at(const PointEvidence& point) {
  load(point.frame);
  const int u = static_cast<int>(std::lround(point.u_px));
  const int v = static_cast<int>(std::lround(point.v_px));
  std::set<int> around;
  std::set<int> at_depth;
  for (int y = std::max(0, v - 1); y <= std::min(height_px_ - 1, v + 1); ++y) {
    for (int x = std::max(0, u - 1); x <= std::min(width_px_ - 1, u + 1); ++x) {
      const auto i = static_cast<std::size_t>(y * width_px_ + x);
      around.insert(ids_[i]);
      if (depth_mm_[i] > 0 && is_near(point.depth_m, 1e-3 * depth_mm_[i])) at_depth.insert(ids_[i]);
    }
  }
  const std::set<int>& owners = around.size() == 1 ? around : at_depth;
  return owners.size() == 1 ? std::optional(*owners.begin()) : std::nullopt;
}

}  // namespace egomod::eval
