// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/descriptor.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr int kCells = 4;  // in each direction
constexpr int kNarrowCell_px = 3;
constexpr int kWideCell_px = 4;
constexpr float kSpread = 40.0F;  // root mean square of the bytes around their centre
constexpr float kCentre = 128.0F;
constexpr float kMinGradient = 0.25F;  // grey levels per pixel, root mean square

using Bytes = std::array<std::uint8_t, Descriptor::kBytes>;
using Gradients = std::array<float, Descriptor::kBytes>;

// Mean central differences of one cell; inner ones cancel, but for two rows or columns at the rims.
template <int kCell>
void cell_gradient(const std::uint8_t* p, std::ptrdiff_t stride, float* gradient) {
  int gu = 0, gv = 0;
  for (int i = 0; i < kCell; ++i) {
    const std::uint8_t* const row = p + i * stride;
    gu += row[kCell] + row[kCell - 1] - row[0] - row[-1];
    gv += p[kCell * stride + i] + p[(kCell - 1) * stride + i] - p[i] - p[i - stride];
  }
  constexpr float scale = 0.5F / static_cast<float>(kCell * kCell);
  gradient[0] = scale * static_cast<float>(gu);
  gradient[1] = scale * static_cast<float>(gv);
}

bool normalise(const Gradients& gradients, Bytes& bytes) {
  float energy = 0.0F;
  for (float g : gradients) energy += g * g;
  const float rms = std::sqrt(energy / static_cast<float>(gradients.size()));
  if (rms < kMinGradient) return false;
  const float gain = kSpread / rms;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(
        std::lround(std::clamp(kCentre + gain * gradients[i], 0.0F, 255.0F)));
  return true;
}

template <int kCell>
bool describe_window(const ImageView& image, ImagePoint centre, Bytes& bytes) {
  constexpr int side = kCells * kCell;
  constexpr float half = 0.5F * static_cast<float>(side - 1);
  const int u = static_cast<int>(std::lround(centre.u_px - half));
  const int v = static_cast<int>(std::lround(centre.v_px - half));
  if (u < 1 || v < 1 || u + side >= image.width_px || v + side >= image.height_px) return false;
  Gradients gradients;
  float* out = gradients.data();
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i, out += 2)
      cell_gradient<kCell>(image.row(v + j * kCell) + u + i * kCell, image.stride_bytes, out);
  return normalise(gradients, bytes);
}

}  // namespace

bool describe(const Pyramid& pyramid, ImagePoint position, Descriptor& descriptor) {
  if (pyramid.levels() < 2) return false;
  const ImageView image = pyramid.level(1);
  const ImagePoint centre = to_level(position, 1);
  return describe_window<kNarrowCell_px>(image, centre, descriptor.narrow) &&
         describe_window<kWideCell_px>(image, centre, descriptor.wide);
}

}  // namespace egomod
