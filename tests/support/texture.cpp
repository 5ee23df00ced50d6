// SPDX-License-Identifier: Apache-2.0
#include "texture.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::test_support {
namespace {

constexpr int kLevels = 7;
constexpr int kSizeMultiple = 1 << (kLevels - 1);  // so that every level halves exactly

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x9E3779B1U ^ y * 0x85EBCA77U ^ seed * 0xC2B2AE3DU;
  h ^= h >> 15U;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12U;
  h *= 0x297A2D39U;
  return h ^ (h >> 15U);
}

double unit(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  return hash(x, y, seed) * (1.0 / 4294967295.0);
}

double lattice(int x, int y, std::uint32_t seed) {
  return 2.0 * unit(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), seed) - 1.0;
}

double ease(double x) { return x * x * (3.0 - 2.0 * x); }

// Noise at 0.5 m down to 1.5 cm: something to see from any distance in the room.
double grain(double s_m, double t_m, std::uint32_t seed) {
  return 0.30 * value_noise(s_m / 0.50, t_m / 0.50, seed) +
         0.30 * value_noise(s_m / 0.13, t_m / 0.13, seed + 1) +
         0.25 * value_noise(s_m / 0.045, t_m / 0.045, seed + 2) +
         0.15 * value_noise(s_m / 0.015, t_m / 0.015, seed + 3);
}

int rounded_up(double texels) {
  return std::max(1, static_cast<int>(std::ceil(texels / kSizeMultiple))) * kSizeMultiple;
}

struct Rectangle {
  double s, t, width, height, grey;
  [[nodiscard]] bool contains(double x, double y) const {
    return x >= s && x < s + width && y >= t && y < t + height;
  }
};

}  // namespace

Texture::Texture(double width_m, double height_m, double texel_m, const Paint& paint) {
  levels_.push_back(smoothed(painted(width_m, height_m, texel_m, paint)));
  while (levels_.size() < kLevels) levels_.push_back(halved(levels_.back()));
}

Texture::Level Texture::painted(double width_m, double height_m, double texel_m,
                                const Paint& paint) {
  Level level{rounded_up(width_m / texel_m), rounded_up(height_m / texel_m), {}};
  level.grey.resize(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
  auto* out = level.grey.data();
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x) {
      const double grey =
          paint((x + 0.5) * width_m / level.width, (y + 0.5) * height_m / level.height);
      *out++ = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
  }
  return level;
}

// Binomial 3x3: painted edges lose what the sampling could only alias.
Texture::Level Texture::smoothed(const Level& sharp) {
  Level out = sharp;
  const auto at = [&](int x, int y) {
    x = std::clamp(x, 0, sharp.width - 1);
    y = std::clamp(y, 0, sharp.height - 1);
    return static_cast<int>(sharp.grey[static_cast<std::size_t>(y * sharp.width + x)]);
  };
  const auto row = [&](int x, int y) { return at(x - 1, y) + 2 * at(x, y) + at(x + 1, y); };
  for (int y = 0; y < sharp.height; ++y) {
    for (int x = 0; x < sharp.width; ++x) {
      out.grey[static_cast<std::size_t>(y * sharp.width + x)] =
          static_cast<std::uint8_t>((row(x, y - 1) + 2 * row(x, y) + row(x, y + 1) + 8) / 16);
    }
  }
  return out;
}

Texture::Level Texture::halved(const Level& fine) {
  Level level{fine.width / 2, fine.height / 2, {}};
  level.grey.reserve(fine.grey.size() / 4);
  for (int y = 0; y < level.height; ++y) {
    const auto* upper = fine.grey.data() + static_cast<std::ptrdiff_t>(2 * y) * fine.width;
    const auto* lower = upper + fine.width;
    for (int x = 0; x < level.width; ++x, upper += 2, lower += 2) {
      level.grey.push_back(
          static_cast<std::uint8_t>((upper[0] + upper[1] + lower[0] + lower[1] + 2) / 4));
    }
  }
  return level;
}

float Texture::Level::bilinear(float x, float y) const {
  x = std::clamp(x, 0.0F, static_cast<float>(width - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(height - 1));
  const int x0 = std::min(static_cast<int>(x), std::max(0, width - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, height - 2));
  const int right = width > 1 ? 1 : 0;
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const auto* p = grey.data() + static_cast<std::ptrdiff_t>(y0) * width + x0;
  const auto* q = p + (height > 1 ? width : 0);
  const float upper = static_cast<float>(p[0]) + fx * static_cast<float>(p[right] - p[0]);
  const float lower = static_cast<float>(q[0]) + fx * static_cast<float>(q[right] - q[0]);
  return upper + fy * (lower - upper);
}

float Texture::sample(float x, float y, float lod) const {
  const float clamped = std::clamp(lod, 0.0F, static_cast<float>(kLevels) - 1.001F);
  const auto fine = static_cast<std::size_t>(clamped);
  const float blend = clamped - static_cast<float>(fine);
  // Texel (i, j) of level L covers texels 2^L i .. 2^L (i + 1) - 1 of level 0.
  const float scale = 1.0F / static_cast<float>(1U << fine);
  const float xf = (x + 0.5F) * scale - 0.5F;
  const float yf = (y + 0.5F) * scale - 0.5F;
  const float near = levels_[fine].bilinear(xf, yf);
  if (blend <= 0.0F) return near;
  const float far = levels_[fine + 1].bilinear((xf - 0.5F) * 0.5F, (yf - 0.5F) * 0.5F);
  return near + blend * (far - near);
}

double value_noise(double x, double y, std::uint32_t seed) {
  const double xf = std::floor(x);
  const double yf = std::floor(y);
  const int xi = static_cast<int>(xf);
  const int yi = static_cast<int>(yf);
  const double a = ease(x - xf);
  const double b = ease(y - yf);
  // std::lerp's care for signs and ends costs more than the hashes.
  const auto mixed = [](double from, double to, double share) {
    return from + share * (to - from);
  };
  const double upper = mixed(lattice(xi, yi, seed), lattice(xi + 1, yi, seed), a);
  const double lower = mixed(lattice(xi, yi + 1, seed), lattice(xi + 1, yi + 1, seed), a);
  return mixed(upper, lower, b);
}

Paint plaster(double base, double contrast, std::uint32_t seed) {
  return [=](double s, double t) { return base + contrast * grain(s, t, seed); };
}

Paint bricks(std::uint32_t seed) {
  constexpr double kLength = 0.25;
  constexpr double kHeight = 0.08;
  constexpr double kMortar = 0.012;
  return [=](double s, double t) {
    const double course = std::floor(t / kHeight);
    const double shifted = s + (static_cast<int>(course) % 2 == 0 ? 0.0 : 0.5 * kLength);
    const double brick = std::floor(shifted / kLength);
    const double ds = shifted - brick * kLength;
    const double dt = t - course * kHeight;
    if (ds < kMortar || dt < kMortar) return 178.0 + 25.0 * grain(s, t, seed);
    const double tone = lattice(static_cast<int>(brick), static_cast<int>(course), seed);
    return 105.0 + 28.0 * tone + 60.0 * grain(s, t, seed + 7);
  };
}

Paint floor_tiles(double tile_m, std::uint32_t seed) {
  constexpr double kJoint = 0.015;
  return [=](double s, double t) {
    const double i = std::floor(s / tile_m);
    const double j = std::floor(t / tile_m);
    const bool joint = s - i * tile_m < kJoint || t - j * tile_m < kJoint;
    const double tone = lattice(static_cast<int>(i), static_cast<int>(j), seed);
    return joint ? 70.0 : 128.0 + 16.0 * tone + 65.0 * grain(s, t, seed + 5);
  };
}

Paint poster(double width_m, double height_m, std::uint32_t seed) {
  std::vector<Rectangle> shapes;
  for (std::uint32_t i = 0; i < 26; ++i) {
    const double size = 0.30 - 0.009 * i;
    shapes.push_back({unit(i, 0, seed) * 0.9 * width_m, unit(i, 1, seed) * 0.9 * height_m,
                      (0.3 + unit(i, 2, seed)) * size * width_m,
                      (0.3 + unit(i, 3, seed)) * size * height_m, 25.0 + 210.0 * unit(i, 4, seed)});
  }
  return [=](double s, double t) {
    const double frame = std::min({s, t, width_m - s, height_m - t});
    if (frame < 0.02) return 35.0;
    if (frame < 0.05) return 225.0;
    double grey = 150.0 + 50.0 * value_noise(s / 0.2, t / 0.2, seed + 9);
    for (const auto& shape : shapes) grey = shape.contains(s, t) ? shape.grey : grey;
    return grey + 18.0 * grain(s, t, seed + 11);
  };
}

Paint carton(double width_m, double height_m, std::uint32_t seed) {
  const Rectangle tape{0.46 * width_m, 0.0, 0.08 * width_m, height_m, 205.0};
  const Rectangle label{0.10 * width_m, 0.55 * height_m, 0.30 * width_m, 0.30 * height_m, 230.0};
  return [=](double s, double t) {
    double grey = 142.0 + 45.0 * grain(s, t, seed);
    if (tape.contains(s, t)) grey = tape.grey + 15.0 * grain(s, t, seed + 1);
    if (!label.contains(s, t)) return grey;
    const double line = std::fmod(t - label.t, 0.12 * height_m) / (0.12 * height_m);
    const bool printed =
        line > 0.45 && value_noise(s / 0.012, std::floor(t / 0.03), seed + 2) > -0.2;
    return printed ? 40.0 : label.grey;
  };
}

Paint robot_side(double width_m, double height_m, bool with_wheels, std::uint32_t seed) {
  return [=](double s, double t) {
    const double body = t < 0.18 * height_m ? 35.0 : 88.0;
    double grey = body + 40.0 * grain(s, t, seed);
    const double button_pitch = width_m / 8.0;
    const double ds = std::fmod(s, button_pitch) - 0.5 * button_pitch;
    const double dt = t - 0.40 * height_m;
    if (std::hypot(ds, dt) < 0.32 * button_pitch) grey = 215.0;  // the ring of sonars
    if (t > 0.62 * height_m && t < 0.70 * height_m) grey = 190.0;
    const double radius = std::hypot(s - 0.32 * width_m, t - 0.95 * height_m);
    if (with_wheels && radius < 0.40 * height_m) grey = radius < 0.2 * height_m ? 165.0 : 22.0;
    return grey;
  };
}

Paint gaussian_spots(double pitch_m, double sigma_m) {
  return [=](double s, double t) {
    const double ds = std::fmod(s, pitch_m) - 0.5 * pitch_m;
    const double dt = std::fmod(t, pitch_m) - 0.5 * pitch_m;
    return 200.0 - 160.0 * std::exp(-0.5 * (ds * ds + dt * dt) / (sigma_m * sigma_m));
  };
}

}  // namespace egomod::test_support
