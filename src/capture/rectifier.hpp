// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture/rectify_kernel.hpp"
#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"

namespace egomod {

// Turns raw images of one camera into rectified ones: bilinear, in fixed point, through a table
// made once. What lies outside of the raw image repeats its nearest border pixel: a smear has no
// corners, while a black margin would grow an edge that moves with the rig.
// Threads: `apply` is const and allocates nothing once `rectified` has grown.
class Rectifier {
 public:
  Rectifier(const RawCamera& raw, const StereoCamera& rectified);

  // `raw` must have the size of the raw camera and the row stride of an Image of that size.
  void apply(const Image& raw, Image& rectified) const;

 private:
  void set_entry(std::size_t index, double u_px, double v_px, const RawCamera& raw);
  void set_groups(const RawCamera& raw);
  [[nodiscard]] RectifyGroup group_of(const std::int32_t* offsets, const RawCamera& raw) const;

  int width_px_;
  int height_px_;
  std::vector<std::int32_t> offsets_;  // byte of the upper left of the four neighbours
  std::vector<RectifyFraction> fractions_;
  std::vector<RectifyGroup> groups_;  // row by row; pixels left over at a row's end are in none
};

}  // namespace egomod
