// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "renderer.hpp"

namespace egomod::sim {

// A rolling shutter reads all rows, one after another, within `readout_s`.
struct Shutter {
  double readout_s = 0.0;
  int strips = 1;  // rows are rendered in so many groups, each at the instant of its middle
};

// How the picture of one camera comes about from renderings through a pinhole: in strips, where
// the shutter rolls, and bent by its lens. A lens needs a pinhole that sees more, as finely as the
// picture does anywhere; its pixels are mixed by cubic convolution. Threads: `develop` is const.
class ImageFormation {
 public:
  // The lens must be invertible.
  ImageFormation(const RawCamera& camera, const Shutter& shutter);

  // Rows of the picture, the rows of the pinhole's that they need, and where these are drawn.
  struct Strip {
    int first_row = 0;
    int end_row = 0;
    double offset_s = 0.0;  // from the instant of the picture's middle
    int first_view_row = 0;
    int end_view_row = 0;
    int canvas_row = 0;
  };
  [[nodiscard]] const std::vector<Strip>& strips() const { return strips_; }
  [[nodiscard]] const Pinhole& pinhole() const { return pinhole_; }
  [[nodiscard]] int canvas_height_px() const { return canvas_height_px_; }
  // `canvas` may come back with an old picture.
  void develop(Image& canvas, Image& out) const;

 private:
  struct Source {
    std::int32_t offset = 0;   // byte of the upper left of the sixteen pixels
    std::uint8_t u_phase = 0;  // of the place between the middle four, 1/256 pixel
    std::uint8_t v_phase = 0;
  };
  void see_through_lens(const RawCamera& camera);
  void lay_out_strips(int height_px, const Shutter& shutter);
  void fill_sources();

  int width_px_;
  int height_px_;
  Pinhole pinhole_;
  int canvas_height_px_ = 0;
  std::vector<Strip> strips_;
  std::vector<Eigen::Vector2d> places_;  // in the pinhole's picture; empty: no lens
  std::vector<Source> sources_;
};

}  // namespace egomod::sim
