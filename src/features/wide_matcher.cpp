// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/wide_matcher.hpp"

#include <algorithm>
#include <limits>

#include "image_kernels.hpp"

namespace egomod {
namespace {

constexpr float kBinSide_px = 32.0F;
constexpr float kSamePlace_px = 8.0F;  // nearer ones are the same corner found twice
constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();

float squared_distance(ImagePoint a, ImagePoint b) {
  const float du = a.u_px - b.u_px, dv = a.v_px - b.v_px;
  return du * du + dv * dv;
}

int bin_along(float position, float start, int bins) {
  return std::clamp(static_cast<int>((position - start) / kBinSide_px), 0, bins - 1);
}

}  // namespace

WideMatcher::WideMatcher(const WideMatchConfig& config) : config_(config) {}

void WideMatcher::lay_out(std::span<const DescribedPoint> candidates) {
  float u0 = 0.0F, v0 = 0.0F, u1 = 0.0F, v1 = 0.0F;
  for (const DescribedPoint& c : candidates) {
    u0 = std::min(u0, c.position.u_px);
    v0 = std::min(v0, c.position.v_px);
    u1 = std::max(u1, c.position.u_px);
    v1 = std::max(v1, c.position.v_px);
  }
  bins_.start = {u0, v0};
  bins_.columns = 1 + static_cast<int>((u1 - u0) / kBinSide_px);
  bins_.rows = 1 + static_cast<int>((v1 - v0) / kBinSide_px);
}

std::size_t WideMatcher::bin_of(ImagePoint p) const {
  const int column = bin_along(p.u_px, bins_.start.u_px, bins_.columns);
  const int row = bin_along(p.v_px, bins_.start.v_px, bins_.rows);
  return static_cast<std::size_t>(row * bins_.columns + column);
}

// Counting sort: stable, so that ties fall to the lower index.
void WideMatcher::sort_into_bins(std::span<const DescribedPoint> candidates) {
  lay_out(candidates);
  bins_.first.assign(static_cast<std::size_t>(bins_.columns * bins_.rows) + 1, 0);
  bins_.order.resize(candidates.size());
  for (const DescribedPoint& c : candidates) ++bins_.first[bin_of(c.position) + 1];
  for (std::size_t i = 1; i < bins_.first.size(); ++i) bins_.first[i] += bins_.first[i - 1];
  for (std::size_t i = candidates.size(); i-- > 0;) {
    const std::size_t bin = bin_of(candidates[i].position);
    bins_.order[static_cast<std::size_t>(--bins_.first[bin + 1])] = static_cast<std::int32_t>(i);
  }
  // Filling from the back has moved each bin's end to its start.
  std::copy(bins_.first.begin() + 1, bins_.first.end(), bins_.first.begin());
  bins_.first.back() = static_cast<std::int32_t>(candidates.size());
}

void WideMatcher::gather(const DescribedPoint& old, std::span<const DescribedPoint> candidates,
                         float radius_px) {
  near_.clear();
  const ImagePoint p = old.position;
  const int c0 = bin_along(p.u_px - radius_px, bins_.start.u_px, bins_.columns);
  const int c1 = bin_along(p.u_px + radius_px, bins_.start.u_px, bins_.columns);
  const int r0 = bin_along(p.v_px - radius_px, bins_.start.v_px, bins_.rows);
  const int r1 = bin_along(p.v_px + radius_px, bins_.start.v_px, bins_.rows);
  for (int r = r0; r <= r1; ++r) {
    const auto row = static_cast<std::size_t>(r * bins_.columns);
    const std::int32_t first = bins_.first[row + static_cast<std::size_t>(c0)];
    const std::int32_t last = bins_.first[row + static_cast<std::size_t>(c1) + 1];
    for (std::int32_t k = first; k < last; ++k) {
      const std::int32_t index = bins_.order[static_cast<std::size_t>(k)];
      const DescribedPoint& candidate = candidates[static_cast<std::size_t>(index)];
      if (candidate.kind == old.kind &&
          squared_distance(candidate.position, p) <= radius_px * radius_px)
        near_.push_back(index);
    }
  }
}

void WideMatcher::measure(const DescribedPoint& old, std::span<const DescribedPoint> candidates) {
  const ImageKernels kernels = image_kernels();
  const int count = static_cast<int>(near_.size());
  const auto compare = [&](const auto& mine, const auto& theirs, std::vector<std::int32_t>& out) {
    out.resize(near_.size());
    kernels.descriptor_distances(mine.data(), theirs.data(), sizeof(DescribedPoint), near_.data(),
                                 count, out.data());
  };
  if (near_.empty()) return;
  const Descriptor &a = old.descriptor, &b = candidates.front().descriptor;
  compare(a.narrow, b.narrow, distances_);
  for (const auto& [mine, theirs] :
       {std::pair(&a.narrow, &b.wide), std::pair(&a.wide, &b.narrow)}) {
    compare(*mine, *theirs, other_scale_);
    for (std::size_t i = 0; i < near_.size(); ++i)
      distances_[i] = std::min(distances_[i], other_scale_[i]);
  }
}

WideMatch WideMatcher::best_of(std::span<const DescribedPoint> candidates) const {
  WideMatch match{.candidate = -1, .distance = kFar, .second_distance = kFar};
  for (std::size_t i = 0; i < near_.size(); ++i)
    if (distances_[i] < match.distance) {
      match.candidate = near_[i];
      match.distance = distances_[i];
    }
  if (match.candidate < 0) return match;
  const ImagePoint best = candidates[static_cast<std::size_t>(match.candidate)].position;
  for (std::size_t i = 0; i < near_.size(); ++i)
    if (distances_[i] < match.second_distance &&
        squared_distance(candidates[static_cast<std::size_t>(near_[i])].position, best) >
            kSamePlace_px * kSamePlace_px)
      match.second_distance = distances_[i];
  return match;
}

bool WideMatcher::is_clear(const WideMatch& match) const {
  return match.candidate >= 0 && match.distance <= config_.max_distance &&
         static_cast<float>(match.distance) <=
             config_.max_ratio * static_cast<float>(match.second_distance);
}

void WideMatcher::match(std::span<const DescribedPoint> olds,
                        std::span<const DescribedPoint> candidates, float radius_px,
                        std::span<WideMatch> matches) {
  sort_into_bins(candidates);
  best_distance_.assign(candidates.size(), kFar);
  best_old_.assign(candidates.size(), -1);
  for (std::size_t i = 0; i < olds.size(); ++i) {
    gather(olds[i], candidates, radius_px);
    measure(olds[i], candidates);
    matches[i] = best_of(candidates);
    for (std::size_t k = 0; k < near_.size(); ++k) {
      const auto candidate = static_cast<std::size_t>(near_[k]);
      if (distances_[k] >= best_distance_[candidate]) continue;
      best_distance_[candidate] = distances_[k];
      best_old_[candidate] = static_cast<std::int32_t>(i);
    }
  }
  for (std::size_t i = 0; i < olds.size(); ++i) {
    WideMatch& m = matches[i];
    const bool mutual = m.candidate >= 0 && best_old_[static_cast<std::size_t>(m.candidate)] ==
                                                static_cast<std::int32_t>(i);
    if (!mutual || !is_clear(m)) m.candidate = -1;
  }
}

}  // namespace egomod
