// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/patch_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "correlation.hpp"

namespace egomod {
namespace {

constexpr int kSide = kSearchPatch_px;
constexpr int kSamePeak_px = 2;
constexpr int kMaxPlaces = padded_count(2 * PatchSearch::kMaxRadius_px + 1);
constexpr std::ptrdiff_t kStripStride = strip_stride(2 * PatchSearch::kMaxRadius_px + 1, kSide);

// Top left corners to try, inclusive.
struct Range {
  int first = 0;
  int last = -1;
  [[nodiscard]] int count() const { return last - first + 1; }
};

Range range_around(int centre, int radius, int size_px) {
  return {std::max(centre - radius, 0), std::min(centre + radius, size_px - kSide)};
}

struct Peak {
  int u = 0;
  int v = 0;
  float ncc = -1.0F;
};

template <class Accept>
Peak highest(const float* ncc, Range u, Range v, Accept accept) {
  Peak best;
  for (int y = v.first; y <= v.last; ++y, ncc += kMaxPlaces)
    for (int x = u.first; x <= u.last; ++x)
      if (ncc[x - u.first] > best.ncc && accept(x, y)) best = {x, y, ncc[x - u.first]};
  return best;
}

}  // namespace

PixelPosition patch_top_left(ImagePoint centre) {
  return {static_cast<std::int32_t>(std::lround(centre.u_px - 3.5F)),
          static_cast<std::int32_t>(std::lround(centre.v_px - 3.5F))};
}

bool copy_patch(const ImageView& image, PixelPosition top_left, SearchPatch& patch) {
  if (top_left.u_px < 0 || top_left.v_px < 0 || top_left.u_px + kSide > image.width_px ||
      top_left.v_px + kSide > image.height_px)
    return false;
  for (int j = 0; j < kSide; ++j)
    std::copy_n(image.row(top_left.v_px + j) + top_left.u_px, kSide, patch.begin() + j * kSide);
  return true;
}

PatchSearch::PatchSearch()
    : strip_(static_cast<std::size_t>(kStripStride * (2 * kMaxRadius_px + kSide))),
      ncc_(static_cast<std::size_t>(kMaxPlaces * (2 * kMaxRadius_px + 1))) {}

PatchSearchResult PatchSearch::search(const ImageView& image, const SearchPatch& patch,
                                      PixelPosition predicted_top_left, int radius_px) {
  const int radius = std::clamp(radius_px, 0, kMaxRadius_px);
  const Range u = range_around(predicted_top_left.u_px, radius, image.width_px);
  const Range v = range_around(predicted_top_left.v_px, radius, image.height_px);
  if (u.count() <= 0 || v.count() <= 0) return {};
  const ImageKernels kernels = image_kernels();
  const CorrelationPatch<kSide> wanted(patch.data(), kSide);
  const std::ptrdiff_t stride = strip_stride(u.count(), kSide);
  copy_strip(image, u.first, v.first, u.count() + kSide - 1, v.count() + kSide - 1, strip_.data(),
             stride);
  for (int j = 0; j < v.count(); ++j)
    kernels.correlate_8(wanted.along(strip_.data() + j * stride, stride, u.count()),
                        ncc_.data() + static_cast<std::ptrdiff_t>(j) * kMaxPlaces);
  const Peak best = highest(ncc_.data(), u, v, [](int, int) { return true; });
  const Peak second = highest(ncc_.data(), u, v, [&](int x, int y) {
    return std::max(std::abs(x - best.u), std::abs(y - best.v)) > kSamePeak_px;
  });
  return {best.ncc > -1.0F, {best.u, best.v}, best.ncc, second.ncc};
}

}  // namespace egomod
