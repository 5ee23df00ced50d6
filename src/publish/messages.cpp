// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/messages.hpp"

#include <algorithm>
#include <cmath>

#include "all_finite.hpp"
#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

using RowMajor66 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

static_assert(static_cast<int>(EstimateStatus::kAmbiguous) == pose_t::STATUS_AMBIGUOUS);
static_assert(static_cast<int>(EstimateReason::kMoverDominates) == pose_t::REASON_MOVER_DOMINATES);
static_assert(static_cast<int>(EstimateReason::kRecalibrated) == pose_t::REASON_RECALIBRATED);
static_assert(static_cast<int>(EstimateReason::kWheelsContradict) ==
              pose_t::REASON_WHEELS_CONTRADICT);

std::int64_t microseconds(Nanoseconds t) {
  return std::chrono::duration_cast<std::chrono::microseconds>(t).count();
}

template <typename Message>
void fill_header(const Frame& frame, Message& message) {
  message.utime = frame.pair.utime_us();
  message.sequence = static_cast<std::int64_t>(frame.pair.sequence);
}

template <typename Message>
void fill_judgement(const Egomotion& motion, Message& message) {
  message.status = static_cast<std::int8_t>(motion.status);
  message.reason = static_cast<std::int8_t>(motion.reason);
  message.quality = static_cast<std::int8_t>(std::clamp(motion.quality, 0, 100));
}

void write(const Matrix6d& from, double (&to)[6][6]) {
  Eigen::Map<RowMajor66> matrix(&to[0][0]);
  matrix = from;
}

bool all_finite(const double (&values)[6][6]) {
  return std::all_of(&values[0][0], &values[0][0] + 36, [](double x) { return std::isfinite(x); });
}

// One sign of the two that mean the same rotation, so that equal poses are equal bytes.
void write_orientation(const Eigen::Matrix3d& R, double (&to)[4]) {
  Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  to[0] = q.w();
  to[1] = q.x();
  to[2] = q.y();
  to[3] = q.z();
}

Eigen::Isometry3d in_body(const Eigen::Isometry3d& T_camera,
                          const Eigen::Isometry3d& T_body_camera) {
  return T_body_camera * T_camera * T_body_camera.inverse();
}

// X (T Exp(xi)) X^-1 = (X T X^-1) Exp(Ad(X) xi): a right perturbation of the camera's motion is one
// of the body's.
Matrix6d in_body(const Matrix6d& covariance, const Eigen::Isometry3d& T_body_camera) {
  const Matrix6d Ad = adjoint(T_body_camera);
  return Ad * covariance * Ad.transpose();
}

// d(R^T t, log R) / d(right perturbation of (R, t)): R^T t -> R^T t + rho - phi x R^T t, and
// log(R Exp(phi)) = log R + J_r(log R)^-1 phi, J_r(a) = J_l(-a).
Matrix6d twist_jacobian(const Eigen::Vector3d& displacement_m,
                        const Eigen::Vector3d& rotation_rad) {
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = skew(displacement_m);
  J.bottomRightCorner<3, 3>() = so3_left_jacobian(-rotation_rad).inverse();
  return J;
}

bool has_interval(const Egomotion& motion) {
  return motion.exposure > motion.previous_exposure &&
         (motion.status == EstimateStatus::kValid || motion.status == EstimateStatus::kAmbiguous);
}

}  // namespace

Eigen::Isometry3d world_from_body(const Frame& frame) {
  return in_body(frame.motion.T_first_current, frame.pair.calibration.T_body_camera);
}

void fill_message(const Frame& frame, pose_t& message) {
  const Egomotion& motion = frame.motion;
  const Eigen::Isometry3d T_world_body = world_from_body(frame);
  fill_header(frame, message);
  Eigen::Vector3d::Map(message.pos) = T_world_body.translation();
  write_orientation(T_world_body.linear(), message.orientation);
  write(in_body(motion.covariance_first_current, frame.pair.calibration.T_body_camera),
        message.covariance);
  fill_judgement(motion, message);
  message.inliers = motion.inliers;
  message.reset_count = static_cast<std::int32_t>(motion.reset_count);
  message.residual = motion.residual_px;
}

void fill_message(const Frame& frame, velocity_t& message) {
  const Egomotion& motion = frame.motion;
  const Eigen::Isometry3d& T_body_camera = frame.pair.calibration.T_body_camera;
  fill_header(frame, message);
  fill_judgement(motion, message);
  message.previous_utime = microseconds(motion.previous_exposure + frame.pair.epoch_offset);
  Vector6d twist = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();
  if (has_interval(motion)) {
    const double interval_s = to_seconds(motion.exposure - motion.previous_exposure);
    const Eigen::Isometry3d T = in_body(motion.T_previous_current, T_body_camera);
    twist << T.linear().transpose() * T.translation(), so3_log(T.linear());
    const Matrix6d J = twist_jacobian(twist.head<3>(), twist.tail<3>()) / interval_s;
    covariance = J * in_body(motion.covariance_previous_current, T_body_camera) * J.transpose();
    twist /= interval_s;
  } else {
    message.previous_utime = message.utime;
  }
  Eigen::Vector3d::Map(message.vel) = twist.head<3>();
  Eigen::Vector3d::Map(message.rotation_rate) = twist.tail<3>();
  write(covariance, message.covariance);
}

void fill_message(const Frame& frame, Nanoseconds publish_end, timing_t& message) {
  fill_header(frame, message);
  message.exposure = frame.pair.exposure.count();
  message.arrival = frame.pair.arrival.count();
  message.n_stages = static_cast<std::int32_t>(kStageCount);
  message.stages.resize(kStageCount);
  for (std::size_t i = 0; i < kStageCount; ++i) {
    const StageTime& time = frame.times[i];
    message.stages[i].name = name(static_cast<Stage>(i));
    message.stages[i].start = time.start.count();
    message.stages[i].end = time.end.count();
  }
  message.stages.back().end = publish_end.count();
}

bool is_finite(const pose_t& message) {
  return all_finite(message.pos) && all_finite(message.orientation) &&
         all_finite(message.covariance) && std::isfinite(message.residual);
}

bool is_finite(const velocity_t& message) {
  return all_finite(message.vel) && all_finite(message.rotation_rate) &&
         all_finite(message.covariance);
}

}  // namespace egomod
