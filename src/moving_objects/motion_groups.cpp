// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/motion_groups.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kSameVelocityChi2 = 11.34;  // 99 %, 3 dof: a link between two points
constexpr double kMemberChi2 = 16.27;        // 99.9 %: a member against the group's mean
// Two points of one body differ by this much for reasons that no covariance holds (rotation).
constexpr double kVelocitySpread_m2ps2 = 1e-4;
constexpr double kDepthShare = 0.12;  // nearby, what is behind starts after a shorter step
constexpr double kDepthSigmas = 2.5;
constexpr double kLeastRig_mps = 0.05;
constexpr float kEchoMargin_px = 25.0F;
constexpr double kHullMargin_m = 0.3;
constexpr double kHullSigmas = 2.0;
constexpr double kLineWidthShare = 0.15;  // of its length
constexpr double kAlongLine = 0.95;       // cosine

Eigen::Matrix3d spread() { return kVelocitySpread_m2ps2 * Eigen::Matrix3d::Identity(); }

double depth_sigma_m(const PointSample& point) {
  return std::sqrt(std::max(0.0, point.position_covariance_m2(2, 2)));
}

struct DepthRange {
  double near_m;
  double far_m;
};

DepthRange depth_range(std::span<const PointSample> points, Members members) {
  double sum = 0.0;
  double sum2 = 0.0;
  for (const auto i : members) {
    sum += points[i].position_m.z();
    sum2 += points[i].position_m.z() * points[i].position_m.z();
  }
  const auto n = static_cast<double>(members.size());
  const double mean = sum / n;
  const double deviation = std::sqrt(std::max(0.0, sum2 / n - mean * mean));
  return {mean - kHullSigmas * deviation - kHullMargin_m,
          mean + kHullSigmas * deviation + kHullMargin_m};
}

}  // namespace

double MotionGroup::chi2() const {
  return velocity_mps.dot(velocity_covariance_m2ps2.inverse() * velocity_mps);
}

MeanVelocity weighted_velocity(std::span<const PointSample> points, Members members,
                               double correlation) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  for (const auto i : members) {
    const Eigen::Matrix3d W = velocity_information(points[i]);
    information += W;
    weighted += W * points[i].velocity_mps;
  }
  const Eigen::Matrix3d covariance = information.inverse();
  // 1/K of independent errors becomes rho + (1 - rho)/K.
  const double inflation =
      mean_variance_factor(members.size(), correlation) * static_cast<double>(members.size());
  return {covariance * weighted, covariance * inflation};
}

Eigen::Matrix3d velocity_information(const PointSample& point) {
  return (point.velocity_covariance_m2ps2 + spread()).inverse();
}

double velocity_chi2(const PointSample& point, const Eigen::Vector3d& velocity_mps) {
  const Eigen::Vector3d e = point.velocity_mps - velocity_mps;
  return e.dot(velocity_information(point) * e);
}

bool slides_along_an_edge(const StereoCamera& camera, std::span<const PointSample> points,
                          Members members) {
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d flow_pxps = Eigen::Vector2d::Zero();
  for (const auto i : members) {
    mean_px += points[i].pixel_px / static_cast<double>(members.size());
    flow_pxps +=
        (project_jacobian(camera, points[i].position_m) * points[i].velocity_mps).head<2>();
  }
  Eigen::Matrix2d scatter_px2 = Eigen::Matrix2d::Zero();
  for (const auto i : members) {
    const Eigen::Vector2d e = points[i].pixel_px - mean_px;
    scatter_px2 += e * e.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(scatter_px2);
  const double width2 = std::max(0.0, axes.eigenvalues()[0]);
  return width2 < kLineWidthShare * kLineWidthShare * axes.eigenvalues()[1] &&
         std::abs(axes.eigenvectors().col(1).dot(flow_pxps)) > kAlongLine * flow_pxps.norm();
}

double purity_of(std::span<const PointSample> points, Members members) {
  const PixelRect rectangle = rectangle_of(points, members);
  const auto [near_m, far_m] = depth_range(points, members);
  int moving = 0;
  int still = 0;
  for (const PointSample& point : points) {
    const double slack_m = kHullSigmas * depth_sigma_m(point);
    if (!contains(rectangle, point.pixel_px) || point.position_m.z() < near_m - slack_m ||
        point.position_m.z() > far_m + slack_m) {
      continue;
    }
    moving += point.moves ? 1 : 0;
    still += point.stands ? 1 : 0;
  }
  return static_cast<double>(moving) / std::max(1, moving + still);
}

bool echoes_surroundings(const MotionGroup& group, std::span<const PointSample> points,
                         const Eigen::Vector3d& rig_velocity_mps) {
  if (rig_velocity_mps.norm() < kLeastRig_mps) return false;
  const Eigen::Matrix3d information = (group.velocity_covariance_m2ps2 + spread()).inverse();
  const auto echoes = [&](double source_m) {
    const double share = 1.0 - group.position_m.z() / source_m;
    const Eigen::Vector3d off = group.velocity_mps - share * rig_velocity_mps;
    return off.dot(information * off) < kSameVelocityChi2;
  };
  const PixelRect& r = group.rectangle;
  const float margin_px =
      std::max(kEchoMargin_px, 0.5F * std::max(r.u_max_px - r.u_min_px, r.v_max_px - r.v_min_px));
  const PixelRect around{r.u_min_px - margin_px, r.v_min_px - margin_px, r.u_max_px + margin_px,
                         r.v_max_px + margin_px};
  int still = 0;
  int sources = 0;
  for (const PointSample& point : points) {
    if (!point.stands || !contains(around, point.pixel_px)) continue;
    ++still;
    sources += echoes(point.position_m.z()) ? 1 : 0;
  }
  return sources >= static_cast<int>(group.count) && 2 * sources >= still;
}

MotionGroups::MotionGroups(const MovingObjectsConfig& config) : config_(config) {
  grouper_.reserve(kReservedTracks);
  moving_.reserve(kReservedTracks);
  linked_.reserve(kReservedTracks);
  members_.reserve(kReservedTracks);
  groups_.reserve(kReservedTracks / kLeastPoints);
}

double MotionGroups::reach_px(double fx_px, double depth_m) const {
  return std::max(config_.neighbour_distance_px, config_.neighbour_distance_m * fx_px / depth_m);
}

bool MotionGroups::linked(const StereoCamera& camera, const PointSample& a,
                          const PointSample& b) const {
  const double depth_m = std::min(a.position_m.z(), b.position_m.z());
  const double depth_slack_m = std::min(config_.neighbour_depth_m, kDepthShare * depth_m) +
                               kDepthSigmas * std::hypot(depth_sigma_m(a), depth_sigma_m(b));
  if ((a.pixel_px - b.pixel_px).norm() > reach_px(camera.fx_px, depth_m) ||
      std::abs(a.position_m.z() - b.position_m.z()) > depth_slack_m) {
    return false;
  }
  const Eigen::Vector3d dv = a.velocity_mps - b.velocity_mps;
  const Eigen::Matrix3d S = a.velocity_covariance_m2ps2 + b.velocity_covariance_m2ps2 + spread();
  return dv.dot(S.inverse() * dv) < kSameVelocityChi2;
}

std::span<const MotionGroup> MotionGroups::find(const StereoCamera& camera,
                                                std::span<const PointSample> points,
                                                const Eigen::Vector3d& rig_velocity_mps) {
  moving_.clear();
  members_.clear();
  groups_.clear();
  double nearest_m = config_.max_depth_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].moves) continue;
    moving_.push_back(static_cast<Grouper::Index>(i));
    nearest_m = std::min(nearest_m, points[i].position_m.z());
  }
  const auto point = [&](Grouper::Index i) -> const PointSample& { return points[moving_[i]]; };
  grouper_.group(
      moving_.size(), reach_px(camera.fx_px, nearest_m),
      [&](auto i) { return point(i).pixel_px.x(); },
      [&](auto i, auto j) { return linked(camera, point(i), point(j)); });
  for (std::size_t g = 0; g < grouper_.size(); ++g) {
    linked_.clear();
    for (const auto i : grouper_[g]) linked_.push_back(moving_[i]);
    add(camera, points, rig_velocity_mps, linked_);
  }
  std::sort(groups_.begin(), groups_.end(), [](const MotionGroup& a, const MotionGroup& b) {
    return a.count != b.count ? a.count > b.count : a.first < b.first;
  });
  return groups_;
}

// Keeps the members that agree with the group's mean velocity: chains of links may drift.
void MotionGroups::add(const StereoCamera& camera, std::span<const PointSample> points,
                       const Eigen::Vector3d& rig_velocity_mps, Members linked_points) {
  if (linked_points.size() < kLeastPoints) return;
  const double rho = config_.error_correlation;
  const Eigen::Vector3d rough_mps = weighted_velocity(points, linked_points, rho).velocity_mps;
  MotionGroup group;
  group.first = members_.size();
  for (const auto i : linked_points) {
    if (velocity_chi2(points[i], rough_mps) < kMemberChi2) members_.push_back(i);
  }
  group.count = members_.size() - group.first;
  if (group.count < kLeastPoints) {
    members_.resize(group.first);
    return;
  }
  const Members kept = members(group);
  const MeanVelocity mean = weighted_velocity(points, kept, rho);
  group.velocity_mps = mean.velocity_mps;
  group.velocity_covariance_m2ps2 = mean.covariance_m2ps2;
  group.position_m = mean_position(points, kept);
  group.rectangle = rectangle_of(points, kept);
  group.slides = slides_along_an_edge(camera, points, kept);
  for (const auto i : kept) group.evidence += points[i].evidence;
  group.evidence /= 1.0 + rho * (static_cast<double>(kept.size()) - 1.0);
  group.purity = purity_of(points, kept);
  group.echoes = echoes_surroundings(group, points, rig_velocity_mps);
  groups_.push_back(group);
}

}  // namespace egomod
