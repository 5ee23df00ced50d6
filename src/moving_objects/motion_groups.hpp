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

// Moving points near each other, whatever their velocities: a thing with all its limbs, if it has
// any.
struct MotionBody {
  std::size_t first = 0;  // members: MotionGroups::members(*this)
  std::size_t count = 0;
};

// Moving points near each other with one velocity.
struct MotionGroup {
  std::size_t first = 0;  // members: MotionGroups::members(*this)
  std::size_t count = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // mean
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();    // of the box around them
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d velocity_covariance_m2ps2 = Eigen::Matrix3d::Zero();
  PixelRect rectangle;
  bool slides =
      false;  // its points lie on a line and move along it: an edge seen through apertures
  bool recedes = false;  // on a line, and along the line of sight or hardly: a border of what rests
  bool slips = false;    // its points move along what their own texture tells least of
  bool echoes = false;   // what repeated texture there would feign
  bool with_rig = false;  // along the rig's own motion, as all that is feigned
  double evidence = 0.0;  // log likelihood ratio of its points together, moving over static
  double purity = 0.0;    // share of the tracks in its rectangle and depth that move
  std::size_t body = 0;   // the one that it is part of
  bool leads = false;     // it is the largest group of its body
  bool leaps = false;     // some of its points move by one long interval only

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
// Of points that lie on one line of the image.
struct LineMotion {
  bool along_line = false;  // an edge seen through apertures slides
  // Along the line of sight, since disparities of both sides of a border mix, or hardly at all.
  bool like_border = false;
};
[[nodiscard]] LineMotion line_motion(const StereoCamera& camera,
                                     std::span<const PointSample> points, Members members);
// Points seen through lines of texture, as of wood or along an edge, slide along them: true when
// they move along their own weak axes on the whole.
[[nodiscard]] bool slips_along_texture(const StereoCamera& camera,
                                       std::span<const PointSample> points, Members members);
// Share of the opinionated points inside the members' rectangle and depth that move.
[[nodiscard]] double purity_of(std::span<const PointSample> points, Members members);

// Repeated texture matched one period off feigns points at a share of their depth that move by the
// rest of it with the rig: true when static points around a group, as many as it has itself, would
// make such echoes. What really leads the rig has more points than that or another velocity.
[[nodiscard]] bool echoes_surroundings(const MotionGroup& group,
                                       std::span<const PointSample> points,
                                       const Eigen::Vector3d& rig_velocity_mps);

// Left of what the right camera sees, something near is matched to look-alikes further away: true
// when several of the static points around a group are much nearer than it and would not be in the
// right image where the group is.
[[nodiscard]] bool lies_on_unseen_border(const StereoCamera& camera, const MotionGroup& group,
                                         std::span<const PointSample> points);

// A floor just ahead of a wide rig is sheared between its images and matched to look-alikes, as
// if it were seen through; so are mirror images in it: true when something nearer rests in the
// same rows of the image or below, but higher than the group, and nothing as far away as low.
[[nodiscard]] bool lies_under_ground(const MotionGroup& group, std::span<const PointSample> points);

// Log likelihood ratio of points that move together, whose errors are correlated.
[[nodiscard]] double joint_evidence(std::span<const PointSample> points, Members members,
                                    double correlation);

// As echoes_surroundings, from a mover's texture: true when the group lies within that of `source`,
// at another depth, and crosses the image as that one does.
[[nodiscard]] bool echoes_mover(const StereoCamera& camera, const MotionGroup& group,
                                const MotionGroup& source, const Eigen::Vector3d& rig_velocity_mps);

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
  // Of the last `find`.
  [[nodiscard]] std::span<const MotionBody> bodies() const { return bodies_; }
  [[nodiscard]] Members members(const MotionBody& body) const {
    return Members(body_members_).subspan(body.first, body.count);
  }

  // Place in `bodies` of the one that the first of them that moves is part of; the number of bodies
  // if none does.
  [[nodiscard]] std::size_t body_of(std::span<const PointSample> points, Members members) const;

  static constexpr std::size_t kLeastPoints = 3;
  // Of what hangs below or stands above, by that of what is beside.
  static constexpr double kUprightReach = 2.25;

 private:
  [[nodiscard]] double reach_px(double fx_px, double depth_m) const;
  [[nodiscard]] bool same_depth(const PointSample& a, const PointSample& b) const;
  [[nodiscard]] bool in_one_body(const StereoCamera& camera, const PointSample& a,
                                 const PointSample& b) const;
  [[nodiscard]] bool linked(const StereoCamera& camera, const PointSample& a,
                            const PointSample& b) const;
  void collect_moving(std::span<const PointSample> points);
  void find_bodies(const StereoCamera& camera, std::span<const PointSample> points);
  void name_leaders();
  void find_echoes(const StereoCamera& camera, const Eigen::Vector3d& rig_velocity_mps);
  void add(const StereoCamera& camera, std::span<const PointSample> points,
           const Eigen::Vector3d& rig_velocity_mps, Members linked_points);

  const MovingObjectsConfig config_;
  Grouper grouper_;
  std::vector<Grouper::Index> moving_;
  double nearest_m_ = 0.0;  // of them
  std::vector<Grouper::Index> linked_;
  std::vector<Grouper::Index> members_;
  std::vector<MotionGroup> groups_;
  std::vector<MotionBody> bodies_;
  std::vector<Grouper::Index> body_members_;
  std::vector<std::size_t> body_of_;  // parallel to the points
  std::vector<bool> is_led_;          // parallel to the bodies
};

}  // namespace egomod
