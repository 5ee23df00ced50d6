// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "egomod/core/calibration.hpp"

namespace egomod {

// Radial-tangential lens of a raw camera (Brown 1966; k1 k2 p1 p2 k3). Normalised coordinates are
// (x/z, y/z) of the raw camera frame.
class Lens {
 public:
  explicit Lens(const RawCamera& camera);

  // Raw pixel of a normalised point. Beyond the radius where the radial polynomial turns back it
  // describes no lens; such points are pulled in to that radius.
  [[nodiscard]] Eigen::Vector2d pixel(Eigen::Vector2d normalised) const;
  // Its inverse, by Newton's method.
  [[nodiscard]] Eigen::Vector2d normalised(const Eigen::Vector2d& pixel) const;

 private:
  [[nodiscard]] Eigen::Vector2d distorted(const Eigen::Vector2d& p) const;
  [[nodiscard]] double radial_slope(double r2) const;
  [[nodiscard]] double turning_radius() const;

  Eigen::Matrix3d K_;
  double k1_, k2_, p1_, p2_, k3_;
  double max_radius_;
};

}  // namespace egomod
