// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "egomod/core/egomotion.hpp"

namespace egomod {

// The pose in the first left camera's frame, composed of motions. Covariances are of right
// perturbations, translation first. Threads: one caller.
class PoseAccumulator {
 public:
  void compose(const Eigen::Isometry3d& T_previous_current, const Matrix6d& covariance);
  // The pose is less certain by that much; what it is stays.
  void doubt(const Matrix6d& covariance) { covariance_ += covariance; }
  // The pose stays, its covariance starts anew, and the reset is counted.
  void reset(const Matrix6d& covariance);

  [[nodiscard]] const Eigen::Isometry3d& T_first_current() const { return T_first_current_; }
  [[nodiscard]] const Matrix6d& covariance() const { return covariance_; }
  [[nodiscard]] std::uint32_t reset_count() const { return reset_count_; }

 private:
  Eigen::Isometry3d T_first_current_ = Eigen::Isometry3d::Identity();
  Matrix6d covariance_ = Matrix6d::Zero();
  std::uint32_t reset_count_ = 0;
};

}  // namespace egomod
