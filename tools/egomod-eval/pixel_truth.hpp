// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "record.hpp"

namespace egomod::eval {

// Stereo places a point at 10 m to about this share of its depth.
[[nodiscard]] inline double depth_slack_m(double depth_m) { return 0.15 + 0.05 * depth_m; }

// What each pixel of the rectified left image shows: mask_0 with ids of objects, and depth_0 where
// it is there. Keeps the images of one frame. Threads: one caller.
class PixelTruth {
 public:
  // Nothing without masks.
  [[nodiscard]] static std::optional<PixelTruth> open(const std::filesystem::path& truth);

  // The object, 0 for what rests for ever, that the point lies on. Nothing where its neighbours
  // belong to several, and its depth is not that of exactly one of them. Throws InputError.
  [[nodiscard]] std::optional<int> object_at(const PointEvidence& point);
  // Depth of what rests for ever there, between the four pixels around it. Nothing at edges, on
  // objects and without depth_0. Throws InputError.
  [[nodiscard]] std::optional<double> resting_depth_at(int frame, double u_px, double v_px);

 private:
  explicit PixelTruth(std::filesystem::path folder, bool has_depth)
      : folder_(std::move(folder)), has_depth_(has_depth) {}
  void load(int frame);

  std::filesystem::path folder_;
  bool has_depth_;
  int frame_ = -1;
  int width_px_ = 0;
  int height_px_ = 0;
  std::vector<std::uint8_t> ids_;
  std::vector<std::uint16_t> depth_mm_;  // 0: unknown
};

}  // namespace egomod::eval
