// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "egomod/core/geometry.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/egomotion/correspondence.hpp"
#include "egomod/egomotion/track_map.hpp"

namespace egomod {

// How much of a motion's covariance the pose's growing one takes on for good. Against a map, errors
// do not add up from pair to pair; they wander slowly with those of the tracks, and new tracks
// carry the pose's error on. Points that err together make all of it larger.
class ErrorGrowth {
 public:
  // `common_error`: of this pair, 1 where points err each on its own (see GaussNewtonSolver).
  void note(double common_error, double dt_s);
  // Without a map (empty), all of it: motions are measured frame to frame.
  [[nodiscard]] double share(std::span<const MapPoint> map, double dt_s) const;

 private:
  double common_error_ = 1.0;
  double pairs_ = 1.0;  // that it was learnt from
};

// An error of the motion that stays for a second or so: that of a second is the pairs' sum, not the
// root of their squares'.
class LastingError {
 public:
  void clear() { second_.setZero(); }
  // What it has come to over the last second, with that of this pair (m, rad), in the current
  // frame. The pose's covariance grows by its square times dt_s.
  [[nodiscard]] const Vector6d& add(const Vector6d& error,
                                    const Eigen::Isometry3d& T_previous_current, double dt_s);

 private:
  Vector6d second_ = Vector6d::Zero();
};

// What is not known of the right camera's turn: near and far points lie too near or too far by it,
// those at the median disparity by a share, and so is the way wrong; and since they are by
// different shares, what rests does not move as one: the way bends a little and turns.
class ScaleDoubt {
 public:
  void clear() { lasting_.clear(); }
  // Returns what the covariance of the new pose grows by, in its frame, and keeps the rest.
  // `scratch`: for the disparities.
  [[nodiscard]] Matrix6d note(const TrackSet& tracks, std::span<const Correspondence> seen,
                              const Eigen::Isometry3d& T_previous_current, double dt_s,
                              std::vector<double>& scratch);
  [[nodiscard]] double sigma() const { return sigma_; }  // share of a length
  // Of this pair's motion, right perturbation.
  [[nodiscard]] const Matrix6d& covariance() const { return covariance_; }

 private:
  double sigma_ = 0.0;
  Matrix6d covariance_ = Matrix6d::Zero();
  LastingError lasting_;
};

}  // namespace egomod
