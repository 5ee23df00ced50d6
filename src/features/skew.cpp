// SPDX-License-Identifier: Apache-2.0
#include "skew.hpp"

#include <Eigen/Cholesky>
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

void Skew::turn(std::span<const Surprise> surprises) {
  if (none() || surprises.size() < kMinSurprises) return;
  // d(u right) / d(rotation), of a point seen there; a shift to the right takes disparity away.
  const auto jacobian = [&](const Surprise& s) -> Eigen::Vector3d {
    const double x =
        (static_cast<double>(s.left.u_px - s.disparity_px) - camera_.cx_px) / camera_.fx_px;
    const double y = (static_cast<double>(s.left.v_px) - camera_.cy_px) / camera_.fy_px;
    return camera_.fx_px * Eigen::Vector3d(-x * y, 1.0 + x * x, -y);
  };
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();
  double square_px2 = 0.0;
  for (const double scale : kScales_px) {
    const double prior = scale * camera_.fx_px / kTurn_px;
    Eigen::Matrix3d H = prior * prior * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    square_px2 = 0.0;
    for (const Surprise& s : surprises) {
      const Eigen::Vector3d J = jacobian(s);
      const double turned_px = J.dot(phi);
      const double r = -static_cast<double>(s.surprise_px) - turned_px;
      const double root = scale * scale / (scale * scale + r * r);
      H += root * root * J * J.transpose();
      b += root * root * J * (r + turned_px);
      square_px2 += turned_px * turned_px;
    }
    phi = H.ldlt().solve(b);
  }
  const double least_px2 = kLeastTurn_px * kLeastTurn_px * static_cast<double>(surprises.size());
  if (!phi.allFinite() || square_px2 < least_px2) return;
  T_later_current_.linear() = so3_exp(phi) * T_later_current_.linear();
  rotation_sigma_rad_ = kLeftOver_px / camera_.fx_px;
}

ImagePoint Skew::shift(ImagePoint left, float disparity_px) const {
  if (none()) return {};
  const double d = std::max(static_cast<double>(disparity_px), kMinDisparity_px);
  const Eigen::Vector3d now(left.u_px, left.v_px, d);
  const Eigen::Vector3d P = T_later_current_ * triangulate(camera_, now);
  if (P.z() < kMinDepth_m) return {};
  const Eigen::Vector3d later = project(camera_, P);
  return {static_cast<float>(later.x() - later.z() - (now.x() - d)),
          static_cast<float>(later.y() - now.y())};
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
  return none() ? 0.0F : static_cast<float>(sigma_px * sigma_px);
}

}  // namespace egomod
