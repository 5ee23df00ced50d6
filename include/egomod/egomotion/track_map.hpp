// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/egomotion/readout.hpp"

namespace egomod {

struct TrackMapConfig {
  double fade_per_s = 1.35;          // growth of a position's covariance while it ages
  int linear_updates = 3;            // first updates of a track that are linear in space
  double max_distance2 = 25.0;       // squared Mahalanobis distance from which an update is cut
  double distrust_rate = 0.3;        // how fast a track that does not fit loses its weight...
  double trust_rate = 0.05;          // ...and how slowly one that fits regains it
  double reset_below_weight = 0.15;  // a track trusted less starts anew where it is seen
};

struct MapPoint {
  std::uint64_t track_id = 0;
  int updates = 0;  // 0: position unknown
  int doubted = 0;  // of them, while the wheels contradicted
  int earlier = 0;  // updates before the map began again
  int held = 0;     // pairs that it was followed in without an update
  int stood = 0;    // pairs without doubt that it stood still in, less those that it moved in
  Eigen::Vector3d P_first_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double static_weight = 1.0;
  // What a second of readout that is not accounted for puts it off by, seen from the last pose.
  Eigen::Vector3d row_error_m_per_s = Eigen::Vector3d::Zero();
};

// How surely a point is known to stand still, 0 to 1.
[[nodiscard]] double known_static(const MapPoint& point);
// It moved against the map, and has not earned its weight since: a new point begins with all of it.
[[nodiscard]] bool is_given_up(const MapPoint& point);

// Where each living track stands in the first left camera's frame, filtered over the track's whole
// life under the belief that it stands still (after H. Badino, A. Yamamoto, T. Kanade, ICCV-W
// 2013). Bounded by the number of living tracks. Threads: one caller.
class TrackMap {
 public:
  explicit TrackMap(const TrackMapConfig& config) : config_(config) {}

  void clear() { points_.clear(); }

  // Drops tracks that died, adds places for new ones: points() runs parallel to `tracks` after.
  void align(std::span<const Track> tracks, double dt_s);
  [[nodiscard]] std::span<const MapPoint> points() const { return points_; }

  // Fuses what the current pair sees from the given pose. `pose_covariance`: right perturbation.
  // `noise_scale` multiplies the observations' covariance. `is_doubted`: that the points stand
  // still is not known from this pair. `is_told`: that no other motion may be the rig's instead.
  // `is_held`: points that are known stay where they are and are only judged.
  // `motion_error_per_s`: see ReadoutLearner, nullptr when the readout is not to be learnt.
  void update(const StereoCamera& camera, std::span<const Track> tracks,
              const Eigen::Isometry3d& T_first_current, const Matrix6d& pose_covariance,
              double noise_scale, bool is_doubted = false, bool is_told = true,
              bool is_held = false, const RowTiming& rows = {},
              const Vector6d* motion_error_per_s = nullptr);
  // Another motion than so far is the world's: points stand where the next update sees them, and
  // are trusted by their shares.
  void begin_again(std::span<const double> shares);
  // Points of the map's first pair were seen when no velocity was known yet: it was this one.
  void note_first_velocity(const StereoCamera& camera, const Eigen::Isometry3d& T_first_previous,
                           const Vector6d& velocity);
  // The readout that is accounted for has changed.
  void change_readout(double change_s);

 private:
  TrackMapConfig config_;
  std::vector<MapPoint> points_;
  std::vector<MapPoint> next_;
};

}  // namespace egomod
