// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/motion_groups.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/moving_objects/evidence_gates.hpp"

namespace egomod {
namespace {

constexpr double kSameVelocityChi2 = 11.34;  // 99 %, 3 dof: a link between two points
constexpr double kMemberChi2 = 16.27;        // 99.9 %: a member against the group's mean
// Two points of one body differ by this much for reasons that no covariance holds (rotation).
constexpr double kVelocitySpread_m2ps2 = 1e-4;
constexpr double kDepthShare = 0.12;  // nearby, what is behind starts after a shorter step
constexpr double kDepthSigmas = 2.5;
constexpr double kLeastRig_mps = 0.05;
constexpr double kWithRig_mps = 0.05;
constexpr double kWithRigShare = 0.2;
constexpr float kEchoMargin_px = 25.0F;
constexpr float kEchoOverlap = 0.8F;     // of the echo's rectangle lies in its source's
constexpr double kEchoDepthStep = 0.12;  // log of the ratio of depths
constexpr double kEchoFlow_pxps = 4.0;
constexpr double kEchoFlowShare = 0.1;
constexpr float kBorderMargin_px = 50.0F;
constexpr double kNearerShare = 0.7;
constexpr double kUnderGround_m = 0.5;
constexpr double kUnderGroundShare = 0.15;  // of its depth
constexpr double kBesideDepth = 0.5;        // and up to the inverse
constexpr std::ptrdiff_t kLeastGround = 3;
constexpr std::ptrdiff_t kLeastNearer = 3;
constexpr double kHullMargin_m = 0.3;
constexpr double kHullSigmas = 2.0;
constexpr float kLeastAspect = 0.4F;
constexpr double kLineWidthShare = 0.15;  // of its length
constexpr double kSlowLineWidthShare = 0.25;
constexpr double kSlow_pxps = 30.0;
constexpr double kAlongLine = 0.95;  // cosine
constexpr double kLeastFlow_pxps = 16.0;
constexpr double kAcrossAtRandom = 0.5;  // of the flow's square, across any axis
constexpr double kSlippingAcross = 0.2;
constexpr double kMostSlip_pxps = 60.0;  // a car's sill moves along itself faster

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

// Along the rig's motion, or against it.
bool moves_with_rig(const Eigen::Vector3d& velocity_mps, const Eigen::Vector3d& rig_mps) {
  const double rig2 = rig_mps.squaredNorm();
  if (rig2 < kLeastRig_mps * kLeastRig_mps) return false;
  const Eigen::Vector3d along_mps = velocity_mps.dot(rig_mps) / rig2 * rig_mps;
  return (velocity_mps - along_mps).norm() < kWithRig_mps + kWithRigShare * along_mps.norm();
}

// A narrow group is judged with what surrounds it: an edge of something that rests, seen before
// what lies behind, makes such groups.
PixelRect widened(PixelRect r) {
  const float width = r.u_max_px - r.u_min_px;
  const float height = r.v_max_px - r.v_min_px;
  const float u_px = std::max(0.0F, 0.5F * (kLeastAspect * height - width));
  const float v_px = std::max(0.0F, 0.5F * (kLeastAspect * width - height));
  return {r.u_min_px - u_px, r.v_min_px - v_px, r.u_max_px + u_px, r.v_max_px + v_px};
}

PixelRect surroundings_of(const PixelRect& r, float least_margin_px) {
  const float margin_px =
      std::max(least_margin_px, 0.5F * std::max(r.u_max_px - r.u_min_px, r.v_max_px - r.v_min_px));
  return {r.u_min_px - margin_px, r.v_min_px - margin_px, r.u_max_px + margin_px,
          r.v_max_px + margin_px};
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

double joint_evidence(std::span<const PointSample> points, Members members, double correlation) {
  double sum = 0.0;
  for (const auto i : members) sum += points[i].evidence;
  return group_evidence(sum, members.size(), correlation);
}

LineMotion line_motion(const StereoCamera& camera, std::span<const PointSample> points,
                       Members members) {
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d flow_pxps = Eigen::Vector2d::Zero();
  Eigen::Vector3d sum_mps = Eigen::Vector3d::Zero();
  for (const auto i : members) {
    mean_px += points[i].pixel_px / static_cast<double>(members.size());
    flow_pxps +=
        (project_jacobian(camera, points[i].position_m) * points[i].velocity_mps).head<2>();
    sum_mps += points[i].velocity_mps;
  }
  Eigen::Matrix2d scatter_px2 = Eigen::Matrix2d::Zero();
  for (const auto i : members) {
    const Eigen::Vector2d e = points[i].pixel_px - mean_px;
    scatter_px2 += e * e.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(scatter_px2);
  const double width2 = std::max(0.0, axes.eigenvalues()[0]);
  const double mean_pxps = flow_pxps.norm() / static_cast<double>(members.size());
  const auto is_line = [&](double width_share) {
    return width2 < width_share * width_share * axes.eigenvalues()[1];
  };
  const bool is_along =
      std::abs(axes.eigenvectors().col(1).dot(flow_pxps)) > kAlongLine * flow_pxps.norm();
  return {.along_line =
              is_along && is_line(mean_pxps < kSlow_pxps ? kSlowLineWidthShare : kLineWidthShare),
          .like_border =
              is_line(kLineWidthShare) &&
              (std::abs(sum_mps.z()) > sum_mps.head<2>().norm() || mean_pxps < kLeastFlow_pxps)};
}

bool slips_along_texture(const StereoCamera& camera, std::span<const PointSample> points,
                         Members members) {
  double across = 0.0;
  for (const auto i : members) {
    const PointSample& point = points[i];
    const Eigen::Vector2d flow_pxps =
        (project_jacobian(camera, point.position_m) * point.velocity_mps).head<2>();
    const double speed_pxps = flow_pxps.norm();
    if (speed_pxps > kMostSlip_pxps) {
      across += 1.0;
    } else if (point.weak_axis.isZero() || !(speed_pxps > 0.0)) {
      across += kAcrossAtRandom;
    } else {
      const double along = flow_pxps.dot(point.weak_axis) / speed_pxps;
      across += 1.0 - along * along;
    }
  }
  return across < kSlippingAcross * static_cast<double>(members.size());
}

double purity_of(std::span<const PointSample> points, Members members) {
  const PixelRect rectangle = widened(rectangle_of(points, members));
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
  const PixelRect around = surroundings_of(group.rectangle, kEchoMargin_px);
  int still = 0;
  int sources = 0;
  for (const PointSample& point : points) {
    if (!point.stands || !contains(around, point.pixel_px)) continue;
    ++still;
    sources += echoes(point.position_m.z()) ? 1 : 0;
  }
  return sources >= static_cast<int>(group.count) && 2 * sources >= still;
}

bool lies_on_unseen_border(const StereoCamera& camera, const MotionGroup& group,
                           std::span<const PointSample> points) {
  PixelRect around = surroundings_of(group.rectangle, kBorderMargin_px);
  around.v_max_px = group.rectangle.v_max_px;  // the floor below it is always nearer
  const double u_px = 0.5 * (group.rectangle.u_min_px + group.rectangle.u_max_px);
  const double unseen_m = camera.fx_px * camera.baseline_m / std::max(u_px, 1.0);
  const double near_m = std::min(kNearerShare * group.position_m.z(), unseen_m);
  return std::count_if(points.begin(), points.end(), [&](const PointSample& point) {
           return point.stands && point.position_m.z() < near_m && contains(around, point.pixel_px);
         }) >= kLeastNearer;
}

bool lies_under_ground(const MotionGroup& group, std::span<const PointSample> points) {
  const Eigen::Vector3d& at_m = group.position_m;
  const double low_m = at_m.y() - std::max(kUnderGround_m, kUnderGroundShare * at_m.z());
  std::ptrdiff_t ground = 0, as_low = 0;
  for (const PointSample& point : points) {
    if (!point.stands) continue;
    const bool is_higher = point.position_m.y() < low_m;
    const double share = point.position_m.z() / at_m.z();
    as_low += !is_higher && share > kBesideDepth && share < 1.0 / kBesideDepth ? 1 : 0;
    ground +=
        is_higher && share < kNearerShare && point.pixel_px.y() > group.rectangle.v_min_px ? 1 : 0;
  }
  return ground >= kLeastGround && as_low < kLeastGround;
}

bool echoes_mover(const StereoCamera& camera, const MotionGroup& group, const MotionGroup& source,
                  const Eigen::Vector3d& rig_velocity_mps) {
  const PixelRect& r = group.rectangle;
  const float area_px2 = intersection_px2(r, r);
  const double ratio = group.position_m.z() / source.position_m.z();
  if (intersection_px2(r, source.rectangle) < kEchoOverlap * area_px2 ||
      std::abs(std::log(ratio)) < kEchoDepthStep) {
    return false;
  }
  const auto flow_pxps = [&](const Eigen::Vector3d& at_m, const Eigen::Vector3d& velocity_mps) {
    return Eigen::Vector2d(
        (project_jacobian(camera, at_m) * (velocity_mps - rig_velocity_mps)).head<2>());
  };
  const Eigen::Vector2d own_pxps = flow_pxps(group.position_m, group.velocity_mps);
  const Eigen::Vector2d other_pxps = flow_pxps(group.position_m / ratio, source.velocity_mps);
  return (own_pxps - other_pxps).norm() < kEchoFlow_pxps + kEchoFlowShare * other_pxps.norm();
}

MotionGroups::MotionGroups(const MovingObjectsConfig& config) : config_(config) {
  grouper_.reserve(kReservedTracks);
  moving_.reserve(kReservedTracks);
  linked_.reserve(kReservedTracks);
  members_.reserve(kReservedTracks);
  groups_.reserve(kReservedTracks / kLeastPoints);
  bodies_.reserve(kReservedTracks);
  body_members_.reserve(kReservedTracks);
  body_of_.reserve(kReservedTracks);
  is_led_.reserve(kReservedTracks);
}

double MotionGroups::reach_px(double fx_px, double depth_m) const {
  return std::max(config_.neighbour_distance_px, config_.neighbour_distance_m * fx_px / depth_m);
}

bool MotionGroups::same_depth(const PointSample& a, const PointSample& b) const {
  const double depth_m = std::min(a.position_m.z(), b.position_m.z());
  const double slack_m = std::min(config_.neighbour_depth_m, kDepthShare * depth_m) +
                         kDepthSigmas * std::hypot(depth_sigma_m(a), depth_sigma_m(b));
  return std::abs(a.position_m.z() - b.position_m.z()) <= slack_m;
}

// Limbs hang below, or swing beside.
bool MotionGroups::in_one_body(const StereoCamera& camera, const PointSample& a,
                               const PointSample& b) const {
  const double reach = reach_px(camera.fx_px, std::min(a.position_m.z(), b.position_m.z()));
  const Eigen::Vector2d off_px = (a.pixel_px - b.pixel_px).cwiseAbs();
  return off_px.x() <= reach && off_px.y() <= kUprightReach * reach && same_depth(a, b);
}

bool MotionGroups::linked(const StereoCamera& camera, const PointSample& a,
                          const PointSample& b) const {
  const double depth_m = std::min(a.position_m.z(), b.position_m.z());
  if ((a.pixel_px - b.pixel_px).norm() > reach_px(camera.fx_px, depth_m) || !same_depth(a, b)) {
    return false;
  }
  const Eigen::Vector3d dv = a.velocity_mps - b.velocity_mps;
  const Eigen::Matrix3d S = a.velocity_covariance_m2ps2 + b.velocity_covariance_m2ps2 + spread();
  return dv.dot(S.inverse() * dv) < kSameVelocityChi2;
}

void MotionGroups::collect_moving(std::span<const PointSample> points) {
  moving_.clear();
  nearest_m_ = config_.max_depth_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].moves) continue;
    moving_.push_back(static_cast<Grouper::Index>(i));
    nearest_m_ = std::min(nearest_m_, points[i].position_m.z());
  }
}

void MotionGroups::find_bodies(const StereoCamera& camera, std::span<const PointSample> points) {
  bodies_.clear();
  body_members_.clear();
  body_of_.resize(points.size());
  const auto point = [&](Grouper::Index i) -> const PointSample& { return points[moving_[i]]; };
  grouper_.group(
      moving_.size(), reach_px(camera.fx_px, nearest_m_),
      [&](auto i) { return point(i).pixel_px.x(); },
      [&](auto i, auto j) { return in_one_body(camera, point(i), point(j)); });
  for (std::size_t b = 0; b < grouper_.size(); ++b) {
    bodies_.push_back({.first = body_members_.size(), .count = grouper_[b].size()});
    for (const auto i : grouper_[b]) {
      body_of_[moving_[i]] = b;
      body_members_.push_back(moving_[i]);
    }
  }
}

std::span<const MotionGroup> MotionGroups::find(const StereoCamera& camera,
                                                std::span<const PointSample> points,
                                                const Eigen::Vector3d& rig_velocity_mps) {
  members_.clear();
  groups_.clear();
  collect_moving(points);
  find_bodies(camera, points);
  const auto point = [&](Grouper::Index i) -> const PointSample& { return points[moving_[i]]; };
  grouper_.group(
      moving_.size(), reach_px(camera.fx_px, nearest_m_),
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
  name_leaders();
  find_echoes(camera, rig_velocity_mps);
  return groups_;
}

// Largest first: what echoes has fewer points than its source.
void MotionGroups::find_echoes(const StereoCamera& camera,
                               const Eigen::Vector3d& rig_velocity_mps) {
  for (std::size_t g = 1; g < groups_.size(); ++g) {
    for (std::size_t source = 0; source < g && !groups_[g].echoes; ++source) {
      groups_[g].echoes = !groups_[source].echoes &&
                          echoes_mover(camera, groups_[g], groups_[source], rig_velocity_mps);
    }
  }
}

std::size_t MotionGroups::body_of(std::span<const PointSample> points, Members members) const {
  const auto first =
      std::find_if(members.begin(), members.end(), [&](auto i) { return points[i].moves; });
  return first == members.end() ? bodies_.size() : body_of_[*first];
}

void MotionGroups::name_leaders() {
  is_led_.assign(bodies_.size(), false);
  for (MotionGroup& group : groups_) {
    group.body = body_of_[members(group).front()];
    group.leads = !is_led_[group.body];
    is_led_[group.body] = true;
  }
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
  group.centre_m = centre_of(points, kept);
  group.size_m = extent_of(points, kept);
  group.rectangle = rectangle_of(points, kept);
  const LineMotion line = line_motion(camera, points, kept);
  group.slides = line.along_line;
  group.recedes = line.like_border;
  group.evidence = joint_evidence(points, kept, rho);
  group.leaps = std::any_of(kept.begin(), kept.end(), [&](auto i) { return points[i].leaps; });
  group.purity = purity_of(points, kept);
  group.slips = slips_along_texture(camera, points, kept);
  group.echoes = echoes_surroundings(group, points, rig_velocity_mps);
  group.with_rig = moves_with_rig(group.velocity_mps, rig_velocity_mps);
  groups_.push_back(group);
}

}  // namespace egomod
