// SPDX-License-Identifier: Apache-2.0
#include "sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace egomod::sim {
namespace {

constexpr std::size_t kNormals = std::size_t{1} << 18U;

std::vector<float> vignette(double loss, int width_px, int height_px) {
  std::vector<float> light;
  light.reserve(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  const double cx = 0.5 * (width_px - 1);
  const double cy = 0.5 * (height_px - 1);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      const double r2 =
          ((u - cx) * (u - cx) + (v - cy) * (v - cy)) / std::max(1e-9, cx * cx + cy * cy);
      light.push_back(static_cast<float>(1.0 - loss * r2));
    }
  }
  return light;
}

std::vector<float> normals(std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<float> normal;
  std::vector<float> values(kNormals);
  for (float& value : values) value = normal(engine);
  return values;
}

double gain(const Realism& r, int eye, double t_s) {
  const double phase = 2.0 * M_PI * t_s / r.gain_drift_period_s;
  // The cameras' controls wander apart a little: the right one lags.
  const double drift = 1.0 + r.gain_drift * std::sin(phase - 0.4 * eye);
  return drift * (eye == 0 ? 1.0 : r.right_gain);
}

// Three taps of the variance asked for, across and down.
void soften(double sigma_px, Image& image) {
  const auto side = static_cast<std::uint32_t>(std::lround(128.0 * sigma_px * sigma_px));
  if (side == 0) return;
  const std::uint32_t middle = 256 - 2 * side;
  const auto width = static_cast<std::size_t>(image.width_px());
  const int last = image.height_px() - 1;
  std::array<std::vector<std::uint32_t>, 3> rows;  // mixed across: above, this, below
  const auto mix = [&](int v, std::vector<std::uint32_t>& out) {
    const std::uint8_t* row = image.row(std::min(v, last));
    out.resize(width);
    for (std::size_t u = 1; u + 1 < width; ++u) {
      out[u] = middle * row[u] + side * (row[u - 1] + row[u + 1]);
    }
    out[0] = (middle + side) * row[0] + side * row[1];
    out[width - 1] = (middle + side) * row[width - 1] + side * row[width - 2];
  };
  mix(0, rows[0]);
  mix(0, rows[1]);
  for (int v = 0; v <= last; ++v) {
    mix(v + 1, rows[2]);
    std::uint8_t* row = image.row(v);
    for (std::size_t u = 0; u < width; ++u) {
      row[u] = static_cast<std::uint8_t>(
          (middle * rows[1][u] + side * (rows[0][u] + rows[2][u]) + 32768U) >> 16U);
    }
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
  }
}

// Standard deviation by grey level.
std::array<float, 256> deviations(const Realism& r) {
  std::array<float, 256> out{};
  for (std::size_t grey = 0; grey < out.size(); ++grey) {
    out[grey] = static_cast<float>(
        std::hypot(r.read_noise, r.shot_noise * std::sqrt(static_cast<double>(grey))));
  }
  return out;
}

}  // namespace

Sensor::Sensor(const Realism& realism, int width_px, int height_px, std::uint32_t seed)
    : realism_(realism),
      seed_(seed),
      light_(vignette(realism.vignetting, width_px, height_px)),
      normal_(normals(seed)) {}

void Sensor::expose(int eye, std::uint64_t pair, double t_s, Image& image) const {
  soften(realism_.softness_px, image);
  const auto deviation = deviations(realism_);
  const auto gained = static_cast<float>(gain(realism_, eye, t_s));
  const auto width = static_cast<std::size_t>(image.width_px());
  std::seed_seq key{std::uint64_t{seed_}, pair, static_cast<std::uint64_t>(eye)};
  std::mt19937 offsets(key);
  for (int v = 0; v < image.height_px(); ++v) {
    std::uint8_t* row = image.row(v);
    const float* light = light_.data() + static_cast<std::size_t>(v) * width;
    const float* noise = normal_.data() + offsets() % (kNormals - width);
    for (std::size_t u = 0; u < width; ++u) {
      const float grey = static_cast<float>(row[u]) * light[u] * gained;
      const float noisy = grey + deviation[row[u]] * noise[u] + 0.5F;
      row[u] = static_cast<std::uint8_t>(std::clamp(noisy, 0.0F, 255.0F));
    }
  }
}

}  // namespace egomod::sim
