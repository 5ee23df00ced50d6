// SPDX-License-Identifier: Apache-2.0
#include "spot_panel.hpp"

#include <algorithm>
#include <cmath>

#include "scenes.hpp"

namespace egomod::sim::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWidth_m = 2.4;
constexpr double kHeight_m = 1.92;
constexpr double kPitch_m = 0.24;
constexpr double kSigma_m = 0.022;
constexpr double kTexel_m = 0.004;
constexpr double kBackground = 200.0;  // of the panel between its spots
constexpr int kReach_px = 5;           // of the window round a spot
constexpr int kRays = 4;               // a pixel, in each direction

// Of what is darker than the background, in the window round the middle.
Vector2d centroid(const std::function<double(int, int)>& grey, int u, int v) {
  Vector2d sum = Vector2d::Zero();
  double weight = 0.0;
  for (int y = v - kReach_px; y <= v + kReach_px; ++y) {
    for (int x = u - kReach_px; x <= u + kReach_px; ++x) {
      const double dark = std::max(0.0, kBackground - 4.0 - grey(x, y));
      sum += dark * Vector2d(x, y);
      weight += dark;
    }
  }
  return sum / weight;
}

double mean_of_rays(const SpotPanel& panel, const ReferenceCamera& camera, int u, int v) {
  double sum = 0.0;
  for (int i = 0; i < kRays * kRays; ++i) {
    const Vector2d offset((i % kRays + 0.5) / kRays - 0.5, (i / kRays + 0.5) / kRays - 0.5);
    sum += panel.grey(camera.centre_m, camera.ray(Vector2d(u, v) + offset));
  }
  return sum / (kRays * kRays);
}

}  // namespace

SpotPanel::SpotPanel(double distance_m, double turn_rad, double lean_rad)
    : paint_(test_support::gaussian_spots(kPitch_m, kSigma_m)) {
  Eigen::Isometry3d T_world_panel = Eigen::Isometry3d::Identity();
  T_world_panel.translate(Vector3d(0, 0, distance_m));
  T_world_panel.rotate(Eigen::AngleAxisd(turn_rad, Vector3d::UnitY()) *
                       Eigen::AngleAxisd(lean_rad, Vector3d::UnitX()));
  patch_.corner_m = T_world_panel * Vector3d(-0.5 * kWidth_m, -0.5 * kHeight_m, 0);
  patch_.edge_s_m = T_world_panel.linear() * Vector3d(kWidth_m, 0, 0);
  patch_.edge_t_m = T_world_panel.linear() * Vector3d(0, kHeight_m, 0);
  patch_.texture = add_texture(scene_, kWidth_m, kHeight_m, kTexel_m, paint_);
  scene_.bodies.emplace_back().patches.push_back(patch_);
  for (double t = 0.5 * kPitch_m; t < kHeight_m; t += kPitch_m) {
    for (double s = 0.5 * kPitch_m; s < kWidth_m; s += kPitch_m) {
      spots_m_.emplace_back(patch_.corner_m + s / kWidth_m * patch_.edge_s_m +
                            t / kHeight_m * patch_.edge_t_m);
    }
  }
}

double SpotPanel::grey(const Vector3d& from_m, const Vector3d& along) const {
  Eigen::Matrix3d M;
  M << patch_.edge_s_m, patch_.edge_t_m, -along;
  const Vector3d st = M.inverse() * (from_m - patch_.corner_m);
  const bool hits = st.head<2>().minCoeff() >= 0.0 && st.head<2>().maxCoeff() <= 1.0;
  return hits ? paint_(st.x() * kWidth_m, st.y() * kHeight_m) : kBackground;
}

std::vector<Vector2d> centroid_errors(const Image& image, const SpotPanel& panel,
                                      const ReferenceCamera& camera) {
  std::vector<Vector2d> errors;
  for (const Vector3d& spot : panel.spots_m()) {
    const Vector2d middle = camera.pixel(spot);
    const int u = static_cast<int>(std::lround(middle.x()));
    const int v = static_cast<int>(std::lround(middle.y()));
    const int margin = kReach_px + 1;
    if (u < margin || v < margin || u >= image.width_px() - margin ||
        v >= image.height_px() - margin) {
      continue;
    }
    const Vector2d seen = centroid([&](int x, int y) { return image.row(y)[x]; }, u, v);
    const Vector2d due =
        centroid([&](int x, int y) { return mean_of_rays(panel, camera, x, y); }, u, v);
    errors.emplace_back(seen - due);
  }
  return errors;
}

ErrorSummary summary_of(const std::vector<Vector2d>& errors_px) {
  ErrorSummary out;
  for (const Vector2d& error : errors_px) {
    ++out.count;
    out.mean_px += error;
    out.rms_px += error.squaredNorm();
    out.largest_px = std::max(out.largest_px, error.norm());
  }
  out.mean_px /= static_cast<double>(out.count);
  out.rms_px = std::sqrt(out.rms_px / static_cast<double>(out.count));
  return out;
}

}  // namespace egomod::sim::test
