// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "egomod/core/image.hpp"
#include "world.hpp"

namespace egomod::sim {

// Makes a rendering look as one of the two cameras would have taken it: softness of lens and colour
// filter, vignetting, exposure, noise that grows with the light. The same seed, eye and pair give
// the same noise.
class Sensor {
 public:
  Sensor(const Realism& realism, int width_px, int height_px, std::uint32_t seed);
  void expose(int eye, std::uint64_t pair, double t_s, Image& image) const;

 private:
  Realism realism_;
  std::uint32_t seed_;
  std::vector<float> light_;   // share that reaches each pixel
  std::vector<float> normal_;  // unit variance, drawn from at random offsets
};

}  // namespace egomod::sim
