// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/disparity_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "correlation.hpp"

namespace egomod {
namespace {

constexpr int kCoarse_px = 8;
constexpr int kFine_px = DisparitySearch::kPatch_px;
constexpr int kFineRadius_px = kFine_px / 2;
constexpr int kMinDisparity_px = -1;
constexpr int kCoarseMargin = 2;  // places tried beyond each end: a peak has two flanks
constexpr int kFineReach_px = 3;
constexpr int kSamePeak_px = 3;
constexpr int kMaxPeaks = 6;
constexpr float kCoarseLag = 0.4F;  // peaks so far behind the best don't win at full resolution
constexpr float kRowGain = 0.15F;
constexpr float kMaxBackRatio = 0.8F;  // of 1 - NCC, from right to left
constexpr float kMinCoarseNcc = 0.3F;  // fine texture is blurred away at half resolution

struct Peak {
  int disparity = 0;  // of the level it was found at
  float ncc = -1.0F;
};

struct Peaks {
  std::array<Peak, kMaxPeaks> peaks;
  int count = 0;

  void add(Peak peak) {
    if (count == kMaxPeaks && peak.ncc <= peaks.back().ncc) return;
    if (count < kMaxPeaks) ++count;
    int i = count - 1;
    for (; i > 0 && peaks[static_cast<std::size_t>(i - 1)].ncc < peak.ncc; --i)
      peaks[static_cast<std::size_t>(i)] = peaks[static_cast<std::size_t>(i - 1)];
    peaks[static_cast<std::size_t>(i)] = peak;
  }
  [[nodiscard]] std::span<const Peak> all() const {
    return {peaks.data(), static_cast<std::size_t>(count)};
  }
};

bool contains(const ImageView& image, int u, int v, int side) {
  return u >= 0 && v >= 0 && u + side <= image.width_px && v + side <= image.height_px;
}

// The local maxima along one row of places, the best first. `step` of disparity from place to
// place.
Peaks local_maxima(const float* ncc, int count, int first_disparity, int step) {
  Peaks peaks;
  for (int i = 1; i + 1 < count; ++i)
    if (ncc[i] >= kMinCoarseNcc && ncc[i] > ncc[i - 1] && ncc[i] >= ncc[i + 1])
      peaks.add({first_disparity + step * i, ncc[i]});
  return peaks;
}

// 1 - NCC is half the squared distance of the normalised patches.
bool is_unique(float ncc, float second_ncc, const DisparityConfig& config) {
  return ncc - second_ncc >= config.min_margin &&
         1.0F - ncc <= config.max_ratio * (1.0F - second_ncc);
}

struct Refined {
  int disparity = 0;
  int row_offset = 0;
  float ncc = -1.0F;
};

using Candidates = std::array<Refined, kMaxPeaks>;

// Places of the other image that disparities from `smallest` to `largest` lead to, cut to the
// image.
struct Places {
  int first = 0;
  int count = 0;
  int first_disparity = 0;
  int step = 0;  // of the disparity, from place to place
};

// Everything that searching one point of `from` in `to` needs.
struct Search {
  const DisparityConfig& config;
  const ImageKernels& kernels;
  const Pyramid& from;
  const Pyramid& to;
  int side;  // -1: `to` is the right image and shows the point further left; 1: it is the left one
  float* strip;
  float* ncc;
  PixelPosition shift{};  // of `to`

  [[nodiscard]] Places places(int u, int smallest, int largest, int last_place) const;
  [[nodiscard]] Peaks coarse(PixelPosition corner) const;
  [[nodiscard]] Refined fine(const CorrelationPatch<kFine_px>& patch, PixelPosition corner,
                             int disparity, int row) const;
  [[nodiscard]] Candidates refined(const CorrelationPatch<kFine_px>& patch,
                                   PixelPosition corner) const;
  [[nodiscard]] DisparityMatch match(PixelPosition corner) const;
};

Places Search::places(int u, int smallest, int largest, int last_place) const {
  const int low = std::max(side < 0 ? u - largest : u + smallest, 0);
  const int high = std::min(side < 0 ? u - smallest : u + largest, last_place);
  return {low, high - low + 1, side * (low - u), side};
}

Peaks Search::coarse(PixelPosition corner) const {
  const ImageView image = from.level(1), other = to.level(1);
  const ImagePoint centre =
      to_level({static_cast<float>(corner.u_px), static_cast<float>(corner.v_px)}, 1);
  const float half = 0.5F * static_cast<float>(kCoarse_px - 1);
  const int u = static_cast<int>(std::lround(centre.u_px - half));
  const int v = static_cast<int>(std::lround(centre.v_px - half));
  const int v_other = v + shift.v_px / 2;
  const Places p = places(u + shift.u_px / 2, -kCoarseMargin,
                          config.max_disparity_px / 2 + kCoarseMargin, other.width_px - kCoarse_px);
  if (!contains(image, u, v, kCoarse_px) || v_other < 0 || v_other + kCoarse_px > other.height_px ||
      p.count <= 0)
    return {};
  const std::ptrdiff_t stride = strip_stride(p.count, kCoarse_px);
  copy_strip(other, p.first, v_other, p.count + kCoarse_px - 1, kCoarse_px, strip, stride);
  const CorrelationPatch<kCoarse_px> patch(image.row(v) + u, image.stride_bytes);
  kernels.correlate_8(patch.along(strip, stride, p.count), ncc);
  return local_maxima(ncc, p.count, p.first_disparity, p.step);
}

Refined Search::fine(const CorrelationPatch<kFine_px>& patch, PixelPosition corner, int disparity,
                     int row) const {
  const ImageView other = to.level(0);
  const int u = corner.u_px - kFineRadius_px + shift.u_px;
  const int v = corner.v_px - kFineRadius_px + row + shift.v_px;
  const Places p = places(u, std::max(disparity - kFineReach_px, kMinDisparity_px),
                          std::min(disparity + kFineReach_px, config.max_disparity_px),
                          other.width_px - kFine_px);
  if (p.count <= 0 || v < 0 || v + kFine_px > other.height_px) return {};
  constexpr std::ptrdiff_t stride = strip_stride(2 * kFineReach_px + 1, kFine_px);
  copy_strip(other, p.first, v, p.count + kFine_px - 1, kFine_px, strip, stride);
  kernels.correlate_11(patch.along(strip, stride, p.count), ncc);
  const int at = static_cast<int>(std::max_element(ncc, ncc + p.count) - ncc);
  return {p.first_disparity + p.step * at, row, ncc[at]};
}

DisparityMatch Search::match(PixelPosition corner) const {
  const ImageView image = from.level(0);
  const int u = corner.u_px - kFineRadius_px, v = corner.v_px - kFineRadius_px;
  if (!contains(image, u, v, kFine_px)) return {.status = MatchStatus::kOutside};
  const CorrelationPatch<kFine_px> patch(image.row(v) + u, image.stride_bytes);
  const Candidates candidates = refined(patch, corner);
  const Refined best =
      *std::max_element(candidates.begin(), candidates.end(),
                        [](const Refined& a, const Refined& b) { return a.ncc < b.ncc; });
  float second = -1.0F;
  for (const Refined& other : candidates)
    if (std::abs(other.disparity - best.disparity) > kSamePeak_px)
      second = std::max(second, other.ncc);
  const MatchStatus status = best.ncc < config.min_ncc              ? MatchStatus::kWeak
                             : !is_unique(best.ncc, second, config) ? MatchStatus::kAmbiguous
                                                                    : MatchStatus::kFound;
  return {status, static_cast<std::int16_t>(best.disparity),
          static_cast<std::int16_t>(best.row_offset), best.ncc, second};
}

// The rows above and below only where they could win: a row changes little of a coarse peak.
Candidates Search::refined(const CorrelationPatch<kFine_px>& patch, PixelPosition corner) const {
  const Peaks peaks = coarse(corner);
  Candidates candidates{};
  float best = -1.0F;
  for (std::size_t i = 0; i < peaks.all().size(); ++i) {
    if (peaks.peaks[i].ncc < peaks.peaks[0].ncc - kCoarseLag) break;
    candidates[i] = fine(patch, corner, 2 * peaks.peaks[i].disparity, 0);
    best = std::max(best, candidates[i].ncc);
  }
  for (Refined& candidate : candidates) {
    if (candidate.ncc <= -1.0F || candidate.ncc < best - kRowGain) continue;
    for (const int row : {-1, 1}) {
      const Refined other = fine(patch, corner, candidate.disparity, row);
      if (other.ncc > candidate.ncc) candidate = other;
    }
  }
  return candidates;
}

// What the right image shows at a match must be found where it came from, and better than anywhere
// else: a point that the right image does not show is matched to something that the left image
// shows at another place.
MatchStatus verified(Search& back, PixelPosition corner, PixelPosition shift,
                     const DisparityMatch& match) {
  back.shift = {-shift.u_px, -shift.v_px};
  const PixelPosition right{corner.u_px - match.disparity_px + shift.u_px,
                            corner.v_px + match.row_offset_px + shift.v_px};
  const DisparityMatch there = back.match(right);
  const bool returns = std::abs(there.disparity_px - match.disparity_px) <= kSamePeak_px &&
                       1.0F - there.ncc <= kMaxBackRatio * (1.0F - there.second_ncc);
  return returns ? MatchStatus::kFound : MatchStatus::kAmbiguous;
}

}  // namespace

DisparitySearch::DisparitySearch(const DisparityConfig& config) : config_(config) {
  config_.max_disparity_px = std::max(config_.max_disparity_px, 0);
  const int places = padded_count(config_.max_disparity_px / 2 + 2 * kCoarseMargin + 1);
  strip_.resize(static_cast<std::size_t>(strip_stride(places, kFine_px) * (kFine_px + 2)));
  ncc_.resize(static_cast<std::size_t>(places));
}

void DisparitySearch::search(const Pyramid& left, const Pyramid& right,
                             std::span<const PixelPosition> corners,
                             std::span<DisparityMatch> matches,
                             std::span<const PixelPosition> right_shifts) {
  const ImageKernels kernels = image_kernels();
  Search search{config_, kernels, left, right, -1, strip_.data(), ncc_.data()};
  Search back{config_, kernels, right, left, 1, strip_.data(), ncc_.data()};
  const bool can = left.levels() > 1 && right.levels() > 1;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!right_shifts.empty()) search.shift = right_shifts[i];
    matches[i] = can ? search.match(corners[i]) : DisparityMatch{.status = MatchStatus::kOutside};
    if (matches[i].status == MatchStatus::kFound)
      matches[i].status = verified(back, corners[i], search.shift, matches[i]);
  }
}

}  // namespace egomod
