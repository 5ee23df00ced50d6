// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "egomod/core/image.hpp"
#include "synthetic_world.hpp"

namespace egomod::sim::test {

// A flat panel of dark round spots in front of a camera: where each of them must be seen follows
// from geometry alone.
class SpotPanel {
 public:
  // Its middle lies at `distance_m` ahead of the world's origin; it is turned about its vertical
  // axis, then leant back.
  SpotPanel(double distance_m, double turn_rad, double lean_rad);

  [[nodiscard]] const test_support::Scene& scene() const { return scene_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& spots_m() const { return spots_m_; }
  // What a ray from the point along the direction meets; the background beside the panel.
  [[nodiscard]] double grey(const Eigen::Vector3d& from_m, const Eigen::Vector3d& along) const;

 private:
  test_support::Scene scene_;
  test_support::Patch patch_;
  test_support::Paint paint_;
  std::vector<Eigen::Vector3d> spots_m_;
};

// A camera as a function: the world ray of a pixel, and the pixel of a world point.
struct ReferenceCamera {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  std::function<Eigen::Vector3d(const Eigen::Vector2d& pixel)> ray;
  std::function<Eigen::Vector2d(const Eigen::Vector3d& P_world_m)> pixel;
};

// Measured centroid of each spot that lies well inside of the image, minus the centroid measured in
// the same way in a picture made by casting many rays a pixel.
[[nodiscard]] std::vector<Eigen::Vector2d> centroid_errors(const Image& image,
                                                           const SpotPanel& panel,
                                                           const ReferenceCamera& camera);
struct ErrorSummary {
  std::size_t count = 0;
  double rms_px = 0.0;
  double largest_px = 0.0;
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
};
[[nodiscard]] ErrorSummary summary_of(const std::vector<Eigen::Vector2d>& errors_px);

}  // namespace egomod::sim::test
