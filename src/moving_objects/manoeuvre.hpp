// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "egomod/core/time.hpp"
#include "moving_objects/body_motion.hpp"

namespace egomod {

// How a velocity came to be known that is the first to be followed.
struct MotionStart {
  double stood_share = 0.0;  // of the points: their velocity may be far behind
  double learnt_s = 0.0;     // how long the points have learnt it
};

// How an object's velocity changes. Filters lag behind a change, and how far one has come of late
// tells how far they are behind: this leads the velocity, and owns up to what may still be wrong.
class Manoeuvre {
 public:
  // The velocity as measured in this pair; the first one, or one long after the last, starts anew.
  void follow(const BodyMotion& body, Nanoseconds now, const MotionStart& start = {});
  // To other axes.
  void rotate(const Eigen::Matrix3d& R_to_from);

  [[nodiscard]] Eigen::Vector3d lead_mps() const;  // to be added to the velocity
  // Beyond it, by what the filters are behind of a velocity that goes on to change alike, as far as
  // that stands out of the noise: for what is told only, since the parts of a body are behind
  // alike.
  [[nodiscard]] Eigen::Vector3d steady_lead_mps() const;
  [[nodiscard]] Eigen::Matrix3d covariance_m2ps2() const;
  // What it may well do now.
  [[nodiscard]] Eigen::Matrix3d acceleration_m2ps4() const;
  // From 1, by how much of itself the velocity may be behind along the line of sight, where filters
  // learn slowest; 0 for what has not started from rest.
  [[nodiscard]] double behind_share() const;
  // The filters knew of what is older than the last few pairs, and may be behind for that.
  [[nodiscard]] bool has_past() const;
  // What has just been found has been because the errors of its points agreed. From 1, falls in
  // about the time that it took to find it.
  [[nodiscard]] double youth() const;

 private:
  struct SteadyLead {
    Eigen::Vector3d mps = Eigen::Vector3d::Zero();
    Eigen::Vector3d of_trend_mps = Eigen::Vector3d::Zero();  // it makes good so much of the trend
    Eigen::Matrix3d covariance_m2ps2 = Eigen::Matrix3d::Zero();
  };
  [[nodiscard]] SteadyLead steady_lead(const BodyMotion& body) const;
  void lead_along(const BodyMotion& body, const Eigen::Matrix3d& onto, double lag_s,
                  SteadyLead& lead) const;

  Nanoseconds now_{-1};
  Nanoseconds begun_{-1};
  MotionStart start_;
  SteadyLead lead_;
  Eigen::Vector3d slow_mps_ = Eigen::Vector3d::Zero();      // the velocity, of late
  Eigen::Vector3d change_mps_ = Eigen::Vector3d::Zero();    // from there to this pair's
  Eigen::Vector3d trend_mps_ = Eigen::Vector3d::Zero();     // mean of changes
  Eigen::Matrix3d unrest_m2ps2_ = Eigen::Matrix3d::Zero();  // mean square of changes
};

}  // namespace egomod
