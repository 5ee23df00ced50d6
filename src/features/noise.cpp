// SPDX-License-Identifier: Apache-2.0
#include "noise.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace egomod {
namespace {

constexpr int kRowStep = 8;
constexpr int kColumnStep = 3;
constexpr int kMaxResponse = 511;
constexpr float kMaskGain = 6.0F;            // of the mask's response to white noise
constexpr float kLowerQuartile = 0.318639F;  // of |x| for x ~ N(0, 1)

using Histogram = std::array<int, kMaxResponse + 1>;

// The mask of J. Immerkaer, Fast noise variance estimation, CVIU 64(2), 1996: blind to planes and
// to straight edges along the axes.
int noise_response(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c, int u) {
  const auto across = [u](const std::uint8_t* row) { return row[u - 1] - 2 * row[u] + row[u + 1]; };
  return std::min(std::abs(across(a) - 2 * across(b) + across(c)), kMaxResponse);
}

// Interpolated inside the histogram's bins, since a quartile of little noise lies within the first.
float quantile(const Histogram& histogram, float wanted) {
  float below = 0.0F;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    const auto here = static_cast<float>(histogram[i]);
    // |x| is rounded to whole numbers: bin 0 is half as wide.
    const float start = i == 0 ? 0.0F : static_cast<float>(i) - 0.5F;
    const float width = i == 0 ? 0.5F : 1.0F;
    if (below + here >= wanted && here > 0.0F) return start + width * (wanted - below) / here;
    below += here;
  }
  return static_cast<float>(kMaxResponse);
}

}  // namespace

// Immerkaer's mean is a quartile here, so that texture on less than most of the image does little.
float estimate_noise_sigma(const ImageView& image) {
  Histogram histogram{};
  int samples = 0;
  for (int v = 1; v + 1 < image.height_px; v += kRowStep) {
    for (int u = 1; u + 1 < image.width_px; u += kColumnStep) {
      // Clipped pixels hide their noise.
      const int grey = image.row(v)[u];
      if (grey == 0 || grey == 255) continue;
      ++samples;
      const int response = noise_response(image.row(v - 1), image.row(v), image.row(v + 1), u);
      ++histogram[static_cast<std::size_t>(response)];
    }
  }
  if (samples == 0) return 0.0F;
  return quantile(histogram, 0.25F * static_cast<float>(samples)) / (kMaskGain * kLowerQuartile);
}

}  // namespace egomod
