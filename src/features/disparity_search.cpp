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

// The local maxima along one row of places, the best first. `leftmost` is at the largest disparity.
Peaks local_maxima(const float* ncc, int count, int largest_disparity) {
  Peaks peaks;
  for (int i = 1; i + 1 < count; ++i)
    if (ncc[i] >= kMinCoarseNcc && ncc[i] > ncc[i - 1] && ncc[i] >= ncc[i + 1])
      peaks.add({largest_disparity - i, ncc[i]});
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

// Everything that searching one corner needs.
struct Search {
  const DisparityConfig& config;
  const ImageKernels& kernels;
  const Pyramid& left;
  const Pyramid& right;
  float* strip;
  float* ncc;
  PixelPosition shift{};  // of the right image

  [[nodiscard]] Peaks coarse(PixelPosition corner) const;
  [[nodiscard]] Refined fine(const CorrelationPatch<kFine_px>& patch, PixelPosition corner,
                             int disparity, int row) const;
  [[nodiscard]] Candidates refined(const CorrelationPatch<kFine_px>& patch,
                                   PixelPosition corner) const;
  [[nodiscard]] DisparityMatch match(PixelPosition corner) const;
};

Peaks Search::coarse(PixelPosition corner) const {
  const ImageView from = left.level(1), to = right.level(1);
  const ImagePoint centre =
      to_level({static_cast<float>(corner.u_px), static_cast<float>(corner.v_px)}, 1);
  const float half = 0.5F * static_cast<float>(kCoarse_px - 1);
  const int u = static_cast<int>(std::lround(centre.u_px - half));
  const int v = static_cast<int>(std::lround(centre.v_px - half));
  const int u_right = u + shift.u_px / 2, v_right = v + shift.v_px / 2;
  const int first = std::max(u_right - config.max_disparity_px / 2 - kCoarseMargin, 0);
  const int last = std::min(u_right + kCoarseMargin, to.width_px - kCoarse_px);
  if (!contains(from, u, v, kCoarse_px) || v_right < 0 || v_right + kCoarse_px > to.height_px ||
      last < first)
    return {};
  const int count = last - first + 1;
  const std::ptrdiff_t stride = strip_stride(count, kCoarse_px);
  copy_strip(to, first, v_right, count + kCoarse_px - 1, kCoarse_px, strip, stride);
  const CorrelationPatch<kCoarse_px> patch(from.row(v) + u, from.stride_bytes);
  kernels.correlate_8(patch.along(strip, stride, count), ncc);
  return local_maxima(ncc, count, u_right - first);
}

Refined Search::fine(const CorrelationPatch<kFine_px>& patch, PixelPosition corner, int disparity,
                     int row) const {
  const ImageView to = right.level(0);
  const int u = corner.u_px - kFineRadius_px + shift.u_px;
  const int v = corner.v_px - kFineRadius_px + row + shift.v_px;
  const int largest = std::min(disparity + kFineReach_px, config.max_disparity_px);
  const int smallest = std::max(disparity - kFineReach_px, kMinDisparity_px);
  const int first = std::max(u - largest, 0), last = std::min(u - smallest, to.width_px - kFine_px);
  if (last < first || v < 0 || v + kFine_px > to.height_px) return {};
  const int count = last - first + 1;
  constexpr std::ptrdiff_t stride = strip_stride(2 * kFineReach_px + 1, kFine_px);
  copy_strip(to, first, v, count + kFine_px - 1, kFine_px, strip, stride);
  kernels.correlate_11(patch.along(strip, stride, count), ncc);
  const int at = static_cast<int>(std::max_element(ncc, ncc + count) - ncc);
  return {u - first - at, row, ncc[at]};
}

DisparityMatch Search::match(PixelPosition corner) const {
  const ImageView from = left.level(0);
  const int u = corner.u_px - kFineRadius_px, v = corner.v_px - kFineRadius_px;
  if (!contains(from, u, v, kFine_px)) return {.status = MatchStatus::kOutside};
  const CorrelationPatch<kFine_px> patch(from.row(v) + u, from.stride_bytes);
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
  Search search{config_, kernels, left, right, strip_.data(), ncc_.data()};
  const bool can = left.levels() > 1 && right.levels() > 1;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!right_shifts.empty()) search.shift = right_shifts[i];
    matches[i] = can ? search.match(corners[i]) : DisparityMatch{.status = MatchStatus::kOutside};
  }
}

}  // namespace egomod
