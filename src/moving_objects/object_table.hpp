// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "moving_objects/lost_objects.hpp"
#include "moving_objects/manoeuvre.hpp"
#include "moving_objects/motion_groups.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// What a group must show beyond its size and purity.
struct ObjectGates {
  double min_speed_mps = 0.0;
  double moving_chi2 = 0.0;  // of a point's velocity or displacement against rest
  double min_evidence = -std::numeric_limits<double>::infinity();  // to become an object
  double confirm_evidence = 0.0;  // to become MOVING, in a leaky sum over pairs
  int confirm_pairs = 1;
  double confirm_s = 0.0;
};

// Objects over time: names that stick to their tracks, evidence before MOVING, coasting and end.
// Bounded: at most `kMostObjects` at a time.
class ObjectTable {
 public:
  ObjectTable(const MovingObjectsConfig& config, const ObjectGates& gates);

  // Objects move on to the current pair; tracks keep their owners.
  void predict(const TrackSet& tracks, const Egomotion& motion);
  // Objects move on to a pair in which nothing could be seen.
  void miss(const TrackSet& tracks);
  // Gives each group to an object: by shared tracks, else by place and velocity, else a new one.
  // `is_slow`: pairs are far apart, and prove an object by their number or by many points that
  // agree.
  void associate(const StereoCamera& camera, std::span<const PointSample> points,
                 const MotionGroups& finder, std::span<const MotionGroup> groups,
                 bool is_slow = false);
  // Measures the objects by their own points, decides their states, forgets the lost ones.
  void update(const StereoCamera& camera, std::span<const PointSample> points,
              bool motion_is_valid);

  void report(std::vector<MovingObject>& objects) const;
  [[nodiscard]] std::int64_t owner(std::size_t track) const { return owners_[track]; }
  // Whether a confirmed object that the track is of has this velocity.
  [[nodiscard]] bool moves_with_owner(std::size_t track, const Eigen::Vector3d& velocity_mps,
                                      const Eigen::Matrix3d& covariance_m2ps2) const;

  static constexpr std::size_t kMostObjects = kReservedObjects;

 private:
  // Upright in left camera axes.
  struct Box {
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  };
  struct Shape {
    Box box;
    PixelRect rectangle;
  };

  struct Velocity {
    Eigen::Vector3d mps = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance_m2ps2 = Eigen::Matrix3d::Zero();
  };
  struct Tracked {
    MovingObject object;  // its velocity is the filters': parts of one body are behind alike
    Velocity latest;      // by its last pairs, too: what is told
    Manoeuvre manoeuvre;
    Nanoseconds first_seen{0};  // whoever has its name
    Nanoseconds first{0};       // since it was lost, if it was
    Nanoseconds outlined{0};    // when its rectangle was measured last
    Nanoseconds last_evidence{0};
    Nanoseconds last_velocity{0};  // when points had it
    int pairs = 0;                 // with evidence
    double evidence = 0.0;         // of its groups, leaky
    bool evident = false;          // a group of this pair is its own
    bool confirmed = false;
    bool swings = false;    // it was known by its limbs first
    bool by_limbs = false;  // and in this pair by them only
    bool by_few = false;    // of its points in this pair, at the velocity that it was due to have
    // Of its groups in this pair: one wrong member stretches the object, not a group.
    std::size_t group = 0;  // points
    std::size_t body = 0;
    Box box;
    double width_m = 0.0;     // the most that it has been
    PixelRect own_rectangle;  // of its members, without what hangs on them
  };

  static constexpr double kKeepPurityShare = 0.5;  // of the purity that opens an object
  static constexpr std::size_t kFewPoints = 2;     // that carry one on

  // It is surely none that repeated texture feigns.
  [[nodiscard]] bool is_known(const Tracked& tracked) const;
  // The free space between them along each axis.
  [[nodiscard]] static Eigen::Vector3d space_between(const Box& a, const Box& b);
  // `sigma_m`: of how far apart they are along the line of sight.
  [[nodiscard]] bool are_near(const Box& a, const Box& b, double sigma_m) const;
  [[nodiscard]] bool stands_apart(std::span<const PointSample> points, const MotionGroup& group,
                                  const Tracked& tracked) const;
  [[nodiscard]] static bool are_seen_past(std::span<const PointSample> points, const Shape& a,
                                          const Shape& b);
  void move_on(const StereoCamera& camera, Nanoseconds exposure,
               const Eigen::Isometry3d& T_current_previous);
  void doubt(double elapsed_s, double unseen_s, MovingObject& object) const;
  [[nodiscard]] Tracked* by_tracks(std::span<const PointSample> points, Members members);
  [[nodiscard]] bool is_another_side(const Tracked& tracked, const MotionGroup& group) const;
  [[nodiscard]] Tracked* by_place(const MotionGroup& group);
  [[nodiscard]] bool carries_on(std::span<const PointSample> points, Members members,
                                const Tracked& tracked) const;
  void disown(std::span<const PointSample> points, Members members);
  void join(std::span<const PointSample> points, Members members, const MotionGroup& group,
            Tracked& tracked);
  void go_on_by_tracks(std::span<const PointSample> points, const MotionGroups& finder,
                       Tracked& tracked);
  void go_on_as_expected(std::span<const PointSample> points, const MotionGroups& finder,
                         Tracked& tracked);
  [[nodiscard]] double least_purity() const;
  [[nodiscard]] Tracked* create(const StereoCamera& camera, std::span<const PointSample> points,
                                const MotionGroup& group, const MotionGroups& finder);
  [[nodiscard]] static Box joined(const Box& a, const Box& b);
  [[nodiscard]] static bool is_at(const PointSample& point, const Box& box);
  [[nodiscard]] static std::optional<Box> trunk_in(Box box);
  [[nodiscard]] static bool hangs_on(const Eigen::Vector3d& position_m, const Box& trunk,
                                     double beside_reach_m);
  [[nodiscard]] bool is_limb(const MotionGroup& group) const;
  [[nodiscard]] bool is_of_limb(const MotionGroup& group, const Tracked& tracked) const;
  void take_group(const MotionGroup& group, Tracked& tracked);
  void adopt_limbs(const StereoCamera& camera, std::span<const PointSample> points,
                   Tracked& tracked);
  [[nodiscard]] bool belongs(const PointSample& point, const Tracked& tracked) const;
  void collect(std::span<const PointSample> points, const Tracked& tracked);
  void measure(const StereoCamera& camera, std::span<const PointSample> points, Tracked& tracked);
  void measure_place(const StereoCamera& camera, std::span<const PointSample> points, Members seen,
                     Tracked& tracked);
  [[nodiscard]] Members outline_of(std::span<const PointSample> points, Members seen,
                                   const Tracked& tracked);
  [[nodiscard]] Members without_stray(const StereoCamera& camera,
                                      std::span<const PointSample> points, Members outline,
                                      double depth_m);
  [[nodiscard]] Members seen_by_both(std::span<const PointSample> points);
  [[nodiscard]] Members trunk_of(std::span<const PointSample> points, Members members,
                                 const Tracked& tracked);
  void measure_motion(std::span<const PointSample> points, Members members, Tracked& tracked);
  [[nodiscard]] bool is_part(std::span<const PointSample> points, const Tracked& older,
                             const Tracked& younger) const;
  void absorb_parts(const StereoCamera& camera, std::span<const PointSample> points);
  [[nodiscard]] bool is_proven(const Tracked& tracked) const;
  [[nodiscard]] bool is_pure(std::span<const PointSample> points, Members members,
                             double share = kKeepPurityShare) const;
  [[nodiscard]] bool is_proper(std::span<const PointSample> points, const Tracked& tracked) const;
  void coast(const StereoCamera& camera, std::span<const PointSample> points, Tracked& tracked);
  void rest(const StereoCamera& camera, std::span<const PointSample> points, Tracked& tracked);
  void forget_lost();
  void remember(const Tracked& tracked);
  [[nodiscard]] bool is_lost(const Tracked& tracked) const;

  const MovingObjectsConfig config_;
  const ObjectGates gates_;
  Nanoseconds now_{0};
  bool is_slow_ = false;
  std::vector<Tracked> objects_;
  std::vector<std::int64_t> owners_;  // parallel to TrackSet::tracks
  std::vector<std::uint64_t> track_ids_;
  std::vector<std::int64_t> previous_owners_;
  std::vector<std::uint64_t> previous_track_ids_;
  std::vector<Grouper::Index> members_;
  std::vector<Grouper::Index> seen_;
  std::vector<Grouper::Index> trunk_;
  std::vector<Grouper::Index> outline_;
  LostObjects lost_;
  std::uint32_t reset_count_ = 0;
  std::int64_t last_id_ = 0;
};

}  // namespace egomod
