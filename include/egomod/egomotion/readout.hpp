// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <span>

#include "egomod/core/calibration.hpp"
#include "egomod/core/egomotion.hpp"
#include "egomod/egomotion/correspondence.hpp"

namespace egomod {

struct MapPoint;

// The rig's velocity at a pair, from the mean ones between pairs: a line through the last three,
// and after a jerk no more than both of their slopes say.
class PairVelocity {
 public:
  void clear() { count_ = 0; }
  void keep(const Vector6d& mean_velocity);
  // If it was this on average since the last pair.
  [[nodiscard]] Vector6d after(const Vector6d& mean_velocity) const;

 private:
  std::array<Vector6d, 2> kept_{};  // the last one first
  std::size_t count_ = 0;
};

// Learns the time of readout from residuals that grow with a point's row times the rig's velocity.
// The map's points, and with them the pose, have taken up part of what the rows displaced, so each
// point knows what a second of readout puts it off by, seen from the last pose, which is taken to
// be right (MapPoint::row_error_m_per_s): only the rest can be seen. Threads: one caller.
class ReadoutLearner {
 public:
  // `is_told`: the residuals are a moving rig's, not a mover's; else nothing is learnt or
  // forgotten.
  void learn(const StereoCamera& camera, std::span<const Correspondence> correspondences,
             std::span<const double> distances2, std::span<const MapPoint> map,
             const Eigen::Isometry3d& T_previous_current, const Eigen::Isometry3d& T_first_current,
             const Vector6d& velocity, double dt_s, bool is_told);

  // Once the shutter is known to be global there is nothing left to learn.
  [[nodiscard]] bool is_none() const { return is_none_; }
  // Zero until it is surely more than that of a global shutter.
  [[nodiscard]] double readout_s() const { return readout_s_; }
  [[nodiscard]] double variance_s2() const;
  // By how much the last pair changed readout_s().
  [[nodiscard]] double change_s() const { return change_s_; }
  // Right perturbation of the last motion by a second of readout that is not accounted for.
  [[nodiscard]] const Vector6d& motion_error_per_s() const { return motion_error_per_s_; }

 private:
  void decide();
  [[nodiscard]] double sigma_s() const;

  Vector6d motion_error_per_s_ = Vector6d::Zero();
  double information_ = 0.0;  // normal equation of the readout alone
  double pull_ = 0.0;
  double scatter_ = 0.0;  // sum of squares of the pairs' surprises
  double age_s_ = 0.0;
  double estimate_s_ = 0.0;
  double readout_s_ = 0.0;
  double change_s_ = 0.0;
  bool is_none_ = false;
};

}  // namespace egomod
