// SPDX-License-Identifier: Apache-2.0
#include "capture/lens.hpp"

#include <Eigen/LU>
#include <limits>

namespace egomod {
namespace {

constexpr double kSearchRadius = 10.0;  // 84 degrees off the axis
constexpr double kSearchStep = 0.01;
constexpr int kMaxNewtonSteps = 30;
constexpr double kConverged = 1e-12;

}  // namespace

Lens::Lens(const RawCamera& camera)
    : K_(camera.K),
      k1_(camera.distortion[0]),
      k2_(camera.distortion[1]),
      p1_(camera.distortion[2]),
      p2_(camera.distortion[3]),
      k3_(camera.distortion[4]),
      max_radius_(turning_radius()) {}

// d(r (1 + k1 r^2 + k2 r^4 + k3 r^6)) / dr.
double Lens::radial_slope(double r2) const {
  return 1.0 + r2 * (3.0 * k1_ + r2 * (5.0 * k2_ + r2 * 7.0 * k3_));
}

double Lens::turning_radius() const {
  for (double r = 0.0; r < kSearchRadius; r += kSearchStep) {
    if (radial_slope(r * r) <= 0.0) return r - kSearchStep;
  }
  return std::numeric_limits<double>::infinity();
}

Eigen::Vector2d Lens::distorted(const Eigen::Vector2d& p) const {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1_ + r2 * (k2_ + r2 * k3_));
  return {x * radial + 2.0 * p1_ * x * y + p2_ * (r2 + 2.0 * x * x),
          y * radial + p1_ * (r2 + 2.0 * y * y) + 2.0 * p2_ * x * y};
}

Eigen::Vector2d Lens::pixel(Eigen::Vector2d normalised) const {
  if (const double r = normalised.norm(); r > max_radius_) normalised *= max_radius_ / r;
  const Eigen::Vector2d d = distorted(normalised);
  return {K_(0, 0) * d.x() + K_(0, 1) * d.y() + K_(0, 2), K_(1, 1) * d.y() + K_(1, 2)};
}

Eigen::Vector2d Lens::normalised(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d target;
  target.y() = (pixel.y() - K_(1, 2)) / K_(1, 1);
  target.x() = (pixel.x() - K_(0, 2) - K_(0, 1) * target.y()) / K_(0, 0);
  Eigen::Vector2d p = target;
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    if (const double r = p.norm(); r > max_radius_) p *= max_radius_ / r;
    const double x = p.x();
    const double y = p.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1_ + r2 * (k2_ + r2 * k3_));
    const double slope = 2.0 * (k1_ + r2 * (2.0 * k2_ + r2 * 3.0 * k3_));
    const double mixed = x * y * slope + 2.0 * p1_ * x + 2.0 * p2_ * y;
    Eigen::Matrix2d J;
    J << radial + x * x * slope + 2.0 * p1_ * y + 6.0 * p2_ * x, mixed, mixed,
        radial + y * y * slope + 6.0 * p1_ * y + 2.0 * p2_ * x;
    const Eigen::Vector2d change = J.inverse() * (target - distorted(p));
    p += change;
    if (change.norm() < kConverged) break;
  }
  return p;
}

}  // namespace egomod
