// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/features/corners.hpp"
#include "egomod/features/descriptor.hpp"
#include "egomod/features/image_point.hpp"

namespace egomod {

struct WideMatchConfig {
  int max_distance = 800;  // sum of absolute differences of the 32 bytes
  float max_ratio = 0.8F;  // best against second best distance
};

struct DescribedPoint {
  ImagePoint position;  // a corner's own, or where an old track is predicted
  CornerKind kind = CornerKind::kDark;
  Descriptor descriptor;
};

struct WideMatch {
  std::int32_t candidate = -1;  // index, -1: none
  std::int32_t distance = 0;
  std::int32_t second_distance = 0;
};

// Finds old points among the corners of an image a long way on (pairs up to 1 s apart): the nearest
// descriptor of the same kind within a radius, if it is mutually the best and clearly better than
// the second. Threads: one caller.
class WideMatcher {
 public:
  explicit WideMatcher(const WideMatchConfig& config);

  // `matches` is parallel to `olds`.
  void match(std::span<const DescribedPoint> olds, std::span<const DescribedPoint> candidates,
             float radius_px, std::span<WideMatch> matches);

 private:
  struct Bins {
    ImagePoint start;
    int columns = 0;
    int rows = 0;
    std::vector<std::int32_t> first;  // of each bin in `order`, and the end
    std::vector<std::int32_t> order;  // candidates, bin by bin
  };

  void lay_out(std::span<const DescribedPoint> candidates);
  [[nodiscard]] std::size_t bin_of(ImagePoint p) const;
  void sort_into_bins(std::span<const DescribedPoint> candidates);
  void gather(const DescribedPoint& old, std::span<const DescribedPoint> candidates,
              float radius_px);
  void measure(const DescribedPoint& old, std::span<const DescribedPoint> candidates);
  [[nodiscard]] WideMatch best_of(std::span<const DescribedPoint> candidates) const;
  [[nodiscard]] bool is_clear(const WideMatch& match) const;

  WideMatchConfig config_;
  Bins bins_;
  std::vector<std::int32_t> near_;       // candidates of the right kind within the radius
  std::vector<std::int32_t> distances_;  // parallel to it
  std::vector<std::int32_t> other_scale_;
  std::vector<std::int32_t> best_old_;  // of each candidate
  std::vector<std::int32_t> best_distance_;
};

}  // namespace egomod
