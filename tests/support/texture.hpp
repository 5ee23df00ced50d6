// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace egomod::test_support {

// Grey value 0..255 of a surface at (s, t) metres from its corner.
using Paint = std::function<double(double s_m, double t_m)>;

// A painted surface as a pyramid of 2x2 means, so that it can be sampled without aliasing.
class Texture {
 public:
  Texture(double width_m, double height_m, double texel_m, const Paint& paint);

  [[nodiscard]] int width_texels() const { return levels_.front().width; }
  [[nodiscard]] int height_texels() const { return levels_.front().height; }
  // Level 0, row by row.
  [[nodiscard]] std::span<const std::uint8_t> texels() const { return levels_.front().grey; }
  // Grey value at texel coordinates of level 0 (texel centres on integers), trilinear; `lod` is the
  // binary logarithm of the footprint in texels.
  [[nodiscard]] float sample(float x, float y, float lod) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> grey;
    [[nodiscard]] float bilinear(float x, float y) const;
  };
  static Level painted(double width_m, double height_m, double texel_m, const Paint& paint);
  static Level smoothed(const Level& sharp);
  static Level halved(const Level& fine);

  std::vector<Level> levels_;
};

// Paints. Lengths in metres, contrast in grey levels; the same seed gives the same picture.
[[nodiscard]] double value_noise(double x, double y, std::uint32_t seed);  // -1..1, cells of size 1
[[nodiscard]] Paint plaster(double base, double contrast, std::uint32_t seed);
[[nodiscard]] Paint bricks(std::uint32_t seed);
[[nodiscard]] Paint floor_tiles(double tile_m, std::uint32_t seed);
[[nodiscard]] Paint poster(double width_m, double height_m, std::uint32_t seed);
[[nodiscard]] Paint carton(double width_m, double height_m, std::uint32_t seed);
[[nodiscard]] Paint robot_side(double width_m, double height_m, bool with_wheels,
                               std::uint32_t seed);
// Round dark spots of Gaussian profile on a grid, first at half a pitch: their centroids are known.
[[nodiscard]] Paint gaussian_spots(double pitch_m, double sigma_m);

}  // namespace egomod::test_support
