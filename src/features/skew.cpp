// SPDX-License-Identifier: Apache-2.0
#include "skew.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kMinDepth_m = 0.05;
constexpr double kMinDisparity_px = 0.3;
constexpr double kMinInterval_s = 1e-3;
constexpr double kNegligible_s = 20e-6;  // a hundredth of a pixel at 1 rad/s
// Of the rig, as long as nothing is known of its motion.
constexpr double kUnknownSpeed_mps = 0.5;
constexpr double kUnknownTurn_radps = 0.5;
// How much of the motion's change since the last pair may not go on.
constexpr double kUnsteadyShare = 0.5;
// Smaller motions of a point's own are mostly noise of its position.
constexpr float kNoise_px = 0.7F;
// Of a turn that surprises tell: those needed, robust scales from coarse to fine (weights of S.
// Geman and D. McClure, 1987), what it may be without any, the least one that is no noise, and what
// is left of it.
constexpr std::size_t kMinSurprises = 20;
constexpr std::array kScales_px{4.0, 2.0, 1.0, 0.5, 0.5};
constexpr double kTurn_px = 3.0;
constexpr double kLeastTurn_px = 0.3;
constexpr double kLeftOver_px = 0.1;
// One jerk surprises three pairs; longer, it is the disparities expected that are wrong, and they
// would stay so if the shift followed them.
constexpr int kMostTurnsInARow = 3;

}  // namespace

void Skew::begin_pair(const StereoCamera& camera, Nanoseconds skew, Nanoseconds interval,
                      bool moving_on) {
  camera_ = camera;
  const double skew_s = to_seconds(skew);
  skew_s_ = std::abs(skew_s) > kNegligible_s ? skew_s : 0.0;
  last_interval_s_ = interval_s_;
  interval_s_ = std::max(to_seconds(interval), kMinInterval_s);
  if (!moving_on) velocity_.reset();
}

void Skew::turn_right_camera(const Eigen::Vector3d& turn_rad) {
  turn_rad_ = turn_rad;
  R_seen_calibrated_ = so3_exp(turn_rad);
}

// The velocity is that of the middle of the interval, and the skew has its middle elsewhere.
void Skew::move(const std::optional<Eigen::Isometry3d>& T_current_previous) {
  T_later_current_.setIdentity();
  translation_sigma_m_ = std::abs(skew_s_) * kUnknownSpeed_mps;
  rotation_sigma_rad_ = std::abs(skew_s_) * kUnknownTurn_radps;
  const std::optional<Vector6d> before = velocity_;
  velocity_.reset();
  if (!T_current_previous) return;
  velocity_ = se3_log(*T_current_previous) / interval_s_;
  Vector6d change = Vector6d::Zero();
  if (before) {
    const double later_s = 0.5 * (interval_s_ + skew_s_);
    change = (*velocity_ - *before) * (later_s / (0.5 * (interval_s_ + last_interval_s_)));
  }
  T_later_current_ = se3_exp(skew_s_ * (*velocity_ + change));
  translation_sigma_m_ = kUnsteadyShare * std::abs(skew_s_) * change.head<3>().norm();
  rotation_sigma_rad_ = kUnsteadyShare * std::abs(skew_s_) * change.tail<3>().norm();
}

// About the vertical only: a pitch or a roll changes disparities of either sign, which tells it
// less well, and a base that drives hardly starts one at once.
void Skew::turn(std::span<const Surprise> surprises) {
  if (is_synchronised() || surprises.size() < kMinSurprises) return;
  double yaw_px = 0.0;
  for (const double scale : kScales_px) {
    double H = scale * scale / (kTurn_px * kTurn_px);
    double b = 0.0;
    for (const Surprise& s : surprises) {
      const double x =
          (static_cast<double>(s.left.u_px - s.disparity_px) - camera_.cx_px) / camera_.fx_px;
      const double J = 1.0 + x * x;
      const double moved_px = -static_cast<double>(s.surprise_px);  // to the right
      const double r = moved_px - J * yaw_px;
      const double root = scale * scale / (scale * scale + r * r);
      H += root * root * J * J;
      b += root * root * J * moved_px;
    }
    yaw_px = b / H;
  }
  turns_in_a_row_ = std::abs(yaw_px) >= kLeastTurn_px ? turns_in_a_row_ + 1 : 0;
  if (turns_in_a_row_ == 0 || turns_in_a_row_ > kMostTurnsInARow) return;
  const Eigen::Vector3d phi = yaw_px / camera_.fx_px * Eigen::Vector3d::UnitY();
  T_later_current_.linear() = so3_exp(phi) * T_later_current_.linear();
  rotation_sigma_rad_ = kLeftOver_px / camera_.fx_px;
}

Eigen::Vector2d Skew::after_turn(const Eigen::Vector2d& right_px) const {
  const Eigen::Vector3d ray =
      R_seen_calibrated_ * Eigen::Vector3d((right_px.x() - camera_.cx_px) / camera_.fx_px,
                                           (right_px.y() - camera_.cy_px) / camera_.fy_px, 1.0);
  return {camera_.fx_px * ray.x() / ray.z() + camera_.cx_px,
          camera_.fy_px * ray.y() / ray.z() + camera_.cy_px};
}

ImagePoint Skew::shift(ImagePoint left, float disparity_px) const {
  if (none()) return {};
  const double d = std::max(static_cast<double>(disparity_px), kMinDisparity_px);
  const Eigen::Vector3d now(left.u_px, left.v_px, d);
  const Eigen::Vector3d P = T_later_current_ * triangulate(camera_, now);
  if (P.z() < kMinDepth_m) return {};
  const Eigen::Vector3d later = project(camera_, P);
  const double lower_px = later.y() - now.y();
  const double right_px = later.x() - later.z();
  if (turn_rad_.isZero(0.0))
    return {static_cast<float>(right_px - (now.x() - d)), static_cast<float>(lower_px)};
  const Eigen::Vector2d seen = after_turn({right_px, later.y()});
  return {static_cast<float>(seen.x() - (now.x() - d)), static_cast<float>(seen.y() - now.y())};
}

ImagePoint Skew::own_shift(ImagePoint own_motion) const {
  if (none()) return {};
  const float square = own_motion.u_px * own_motion.u_px + own_motion.v_px * own_motion.v_px;
  const float share =
      static_cast<float>(skew_s_ / interval_s_) * square / (square + kNoise_px * kNoise_px);
  return {share * own_motion.u_px, share * own_motion.v_px};
}

float Skew::variance_px2(float disparity_px) const {
  const double sigma_px = camera_.fx_px * rotation_sigma_rad_ + static_cast<double>(disparity_px) /
                                                                    camera_.baseline_m *
                                                                    translation_sigma_m_;
  return is_synchronised() ? 0.0F : static_cast<float>(sigma_px * sigma_px);
}

}  // namespace egomod
