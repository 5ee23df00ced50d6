// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/pose_accumulator.hpp"

#include "egomod/core/geometry.hpp"

namespace egomod {

// T Exp(a) D Exp(b) = T D Exp(Ad(D^-1) a) Exp(b).
void PoseAccumulator::compose(const Eigen::Isometry3d& T_previous_current,
                              const Matrix6d& covariance) {
  const Matrix6d Ad = adjoint(T_previous_current.inverse());
  T_first_current_ = orthonormalised(T_first_current_ * T_previous_current);
  covariance_ = Ad * covariance_ * Ad.transpose() + covariance;
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void PoseAccumulator::reset(const Matrix6d& covariance) {
  covariance_ = covariance;
  ++reset_count_;
}

}  // namespace egomod
