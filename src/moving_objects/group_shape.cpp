// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/group_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr std::size_t kLeastToStray = 4;  // points: among fewer none is alone

struct Extremes {
  Eigen::Vector3d low_m;
  Eigen::Vector3d high_m;
};

Extremes extremes_of(std::span<const PointSample> points, Members members) {
  Extremes e{points[members.front()].position_m, points[members.front()].position_m};
  for (const auto i : members) {
    e.low_m = e.low_m.cwiseMin(points[i].position_m);
    e.high_m = e.high_m.cwiseMax(points[i].position_m);
  }
  return e;
}

}  // namespace

PixelRect rectangle_of(std::span<const PointSample> points, Members members) {
  Eigen::Vector2d low = points[members.front()].pixel_px;
  Eigen::Vector2d high = low;
  for (const auto i : members) {
    low = low.cwiseMin(points[i].pixel_px);
    high = high.cwiseMax(points[i].pixel_px);
  }
  return {static_cast<float>(low.x()), static_cast<float>(low.y()), static_cast<float>(high.x()),
          static_cast<float>(high.y())};
}

std::size_t stray_of(std::span<const PointSample> points, Members members, double least_px) {
  if (members.size() < kLeastToStray) return members.size();
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::size_t leftmost = 0;
  std::size_t rightmost = 0;
  double left_px[2] = {kNone, kNone};  // and the next
  double right_px[2] = {-kNone, -kNone};
  for (std::size_t k = 0; k < members.size(); ++k) {
    const double u_px = points[members[k]].pixel_px.x();
    if (u_px < left_px[0]) leftmost = k;
    left_px[1] = std::min(left_px[1], std::max(left_px[0], u_px));
    left_px[0] = std::min(left_px[0], u_px);
    if (u_px > right_px[0]) rightmost = k;
    right_px[1] = std::max(right_px[1], std::min(right_px[0], u_px));
    right_px[0] = std::max(right_px[0], u_px);
  }
  const double on_left_px = left_px[1] - left_px[0];
  const double on_right_px = right_px[0] - right_px[1];
  if (on_left_px > std::max(least_px, right_px[0] - left_px[1])) return leftmost;
  if (on_right_px > std::max(least_px, right_px[1] - left_px[0])) return rightmost;
  return members.size();
}

Eigen::Vector3d mean_position(std::span<const PointSample> points, Members members) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto i : members) sum += points[i].position_m;
  return sum / static_cast<double>(members.size());
}

Eigen::Vector3d mean_velocity(std::span<const PointSample> points, Members members) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto i : members) sum += points[i].velocity_mps;
  return sum / static_cast<double>(members.size());
}

Eigen::Vector3d centre_of(std::span<const PointSample> points, Members members) {
  const Extremes e = extremes_of(points, members);
  return 0.5 * (e.low_m + e.high_m);
}

Eigen::Vector3d extent_of(std::span<const PointSample> points, Members members) {
  const Extremes e = extremes_of(points, members);
  return e.high_m - e.low_m;
}

PixelRect carried(const StereoCamera& camera, const PixelRect& rectangle,
                  const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  constexpr double kNearest_m = 0.05;
  constexpr PixelRect kOutOfView{0.0F, 0.0F, -1.0F, -1.0F};
  if (!(from_m.z() > kNearest_m) || !(to_m.z() > kNearest_m)) return kOutOfView;
  const Eigen::Vector2d from_px = project(camera, from_m).head<2>();
  const Eigen::Vector2d to_px = project(camera, to_m).head<2>();
  const double scale = from_m.z() / to_m.z();
  const auto moved = [&](float u_px, float v_px) -> Eigen::Vector2d {
    return to_px + scale * (Eigen::Vector2d(u_px, v_px) - from_px);
  };
  const Eigen::Vector2d last_px(camera.width_px - 1, camera.height_px - 1);
  const Eigen::Vector2d low = moved(rectangle.u_min_px, rectangle.v_min_px).cwiseMax(0.0);
  const Eigen::Vector2d high = moved(rectangle.u_max_px, rectangle.v_max_px).cwiseMin(last_px);
  if (!(low.x() <= high.x() && low.y() <= high.y())) return kOutOfView;
  return {static_cast<float>(low.x()), static_cast<float>(low.y()), static_cast<float>(high.x()),
          static_cast<float>(high.y())};
}

PixelRect shrunk(const PixelRect& before, const PixelRect& now, double kept) {
  if (before.u_max_px < before.u_min_px) return now;
  const auto share = static_cast<float>(kept);
  return {now.u_min_px + share * std::min(0.0F, before.u_min_px - now.u_min_px),
          now.v_min_px + share * std::min(0.0F, before.v_min_px - now.v_min_px),
          now.u_max_px + share * std::max(0.0F, before.u_max_px - now.u_max_px),
          now.v_max_px + share * std::max(0.0F, before.v_max_px - now.v_max_px)};
}

float intersection_px2(const PixelRect& a, const PixelRect& b) {
  const float width = std::min(a.u_max_px, b.u_max_px) - std::max(a.u_min_px, b.u_min_px) + 1.0F;
  const float height = std::min(a.v_max_px, b.v_max_px) - std::max(a.v_min_px, b.v_min_px) + 1.0F;
  return std::max(0.0F, width) * std::max(0.0F, height);
}

PixelRect gap_between(const PixelRect& a, const PixelRect& b) {
  const auto [u_low, u_high] =
      std::minmax(std::max(a.u_min_px, b.u_min_px), std::min(a.u_max_px, b.u_max_px));
  const auto [v_low, v_high] =
      std::minmax(std::max(a.v_min_px, b.v_min_px), std::min(a.v_max_px, b.v_max_px));
  if (intersection_px2(a, b) > 0.0F) return {0.0F, 0.0F, -1.0F, -1.0F};
  return {u_low, v_low, u_high, v_high};
}

bool contains(const PixelRect& rectangle, const Eigen::Vector2d& pixel_px) {
  return pixel_px.x() >= rectangle.u_min_px && pixel_px.x() <= rectangle.u_max_px &&
         pixel_px.y() >= rectangle.v_min_px && pixel_px.y() <= rectangle.v_max_px;
}

double mean_variance_factor(std::size_t count, double correlation) {
  return correlation + (1.0 - correlation) / static_cast<double>(count);
}

Eigen::Matrix3d mean_covariance(std::span<const PointSample> points, Members members,
                                double correlation, Eigen::Matrix3d PointSample::*own) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto i : members) sum += points[i].*own;
  return mean_variance_factor(members.size(), correlation) / static_cast<double>(members.size()) *
         sum;
}

void set_speed(MovingObject& object) {
  object.speed_mps = object.velocity_mps.norm();
  const Eigen::Vector3d direction = object.speed_mps > 0.0
                                        ? Eigen::Vector3d(object.velocity_mps / object.speed_mps)
                                        : Eigen::Vector3d::UnitZ();
  object.speed_sigma_mps =
      std::sqrt(std::max(0.0, direction.dot(object.velocity_covariance_m2ps2 * direction)));
}

}  // namespace egomod
