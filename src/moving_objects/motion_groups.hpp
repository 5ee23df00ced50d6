// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "moving_objects/group_shape.hpp"
#include "moving_objects/grouping.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// Moving points near each other with one velocity.
struct MotionGroup {
  std::size_t first = 0;  // members: MotionGroups::members(*this)
  std::size_t count = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d velocity_covariance_m2ps2 = Eigen::Matrix3d::Zero();
  PixelRect rectangle;
  bool slides =
      false;  // its points lie on a line and move along it: an edge seen through apertures
  bool echoes = false;    // what repeated texture behind it would feign
  double evidence = 0.0;  // log likelihood ratio of its points together, moving over static
  double purity = 0.0;    // share of the tracks in its rectangle and depth that move

  // Chi-square of the velocity against rest.
  [[nodiscard]] double chi2() const;
};

// Mean velocity by inverse covariance of points whose errors correlate.
struct MeanVelocity {
  Eigen::Vector3d velocity_mps;
  Eigen::Matrix3d covariance_m2ps2;
};
[[nodiscard]] MeanVelocity weighted_velocity(std::span<const PointSample> points, Members members,
                                             double correlation);
// Inverse covariance of a point's velocity as that of its body.
[[nodiscard]] Eigen::Matrix3d velocity_information(const PointSample& point);
// Chi-square of a point's velocity against another one.
[[nodiscard]] double velocity_chi2(const PointSample& point, const Eigen::Vector3d& velocity_mps);
// True when the points lie on one line of the image and move along it.
[[nodiscard]] bool slides_along_an_edge(const StereoCamera& camera,
                                        std::span<const PointSample> points, Members members);
// Share of the opinionated points inside the members' rectangle and depth that move.
[[nodiscard]] double purity_of(std::span<const PointSample> points, Members members);

// Repeated texture matched one period off feigns points at a share of their depth that move by the
// rest of it with the rig: true when static points around a group, as many as it has itself, would
// make such echoes. What really leads the rig has more points than that or another velocity.
[[nodiscard]] bool echoes_surroundings(const MotionGroup& group,
                                       std::span<const PointSample> points,
                                       const Eigen::Vector3d& rig_velocity_mps);

// Finds the groups. Neighbourhood is counted in metres across the line of sight, in pixels, and in
// depth by its own uncertainty, so that a far object does not fall apart along z.
class MotionGroups {
 public:
  explicit MotionGroups(const MovingObjectsConfig& config);

  // Groups of at least `kLeastPoints`, largest first.
  std::span<const MotionGroup> find(const StereoCamera& camera, std::span<const PointSample> points,
                                    const Eigen::Vector3d& rig_velocity_mps);
  [[nodiscard]] Members members(const MotionGroup& group) const {
    return Members(members_).subspan(group.first, group.count);
  }

  static constexpr std::size_t kLeastPoints = 3;

 private:
  [[nodiscard]] double reach_px(double fx_px, double depth_m) const;
  [[nodiscard]] bool linked(const StereoCamera& camera, const PointSample& a,
                            const PointSample& b) const;
  void add(const StereoCamera& camera, std::span<const PointSample> points,
           const Eigen::Vector3d& rig_velocity_mps, Members linked_points);

  const MovingObjectsConfig config_;
  Grouper grouper_;
  std::vector<Grouper::Index> moving_;
  std::vector<Grouper::Index> linked_;
  std::vector<Grouper::Index> members_;
  std::vector<MotionGroup> groups_;
};

}  // namespace egomod
