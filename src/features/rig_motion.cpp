// SPDX-License-Identifier: Apache-2.0
#include "rig_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr std::size_t kMaxSamples = 160;
constexpr std::size_t kMinSamples = 12;
constexpr double kMinDepth_m = 0.05;
constexpr float kMinDisparity_px = 0.3F;
// Robust scales, coarse to fine: a mover must not hold the solution at the first one.
constexpr std::array kScales_px{24.0, 12.0, 6.0, 3.0, 2.0, 2.0};
constexpr std::size_t kFirstOfKnown = 2;  // of the scales, where the last motion goes on
constexpr double kNear_px = 3.0;
constexpr double kMinShareNear = 0.4;
// A rig that moves its image less rests: what is left of so small a guess is noise, and all tracks
// that start from it would share it.
constexpr double kRest_px = 0.05;

Eigen::Vector2d normalised(const StereoCamera& camera, ImagePoint p) {
  return {(static_cast<double>(p.u_px) - camera.cx_px) / camera.fx_px,
          (static_cast<double>(p.v_px) - camera.cy_px) / camera.fy_px};
}

}  // namespace

void RigMotion::begin_pair(const StereoCamera& camera, bool moving_on, float interval_ratio) {
  known_ = known_ && moving_on && camera == camera_;
  camera_ = camera;
  if (!known_) T_current_previous_ = Eigen::Isometry3d::Identity();
  if (interval_ratio != 1.0F)
    T_current_previous_ =
        se3_exp(static_cast<double>(interval_ratio) * se3_log(T_current_previous_));
  samples_.reserve(kMaxSamples);
}

void RigMotion::gather(const TrackStore& store) {
  samples_.clear();
  const auto usable = [](const FollowedPoint& p) {
    return p.followed && p.previous_stereo.disparity_px >= kMinDisparity_px;
  };
  const std::vector<FollowedPoint>& points = store.points();
  const auto count = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), usable));
  std::size_t seen = 0;
  for (const FollowedPoint& p : points) {
    if (!usable(p)) continue;
    // Evenly, since old and new tracks lie in order.
    const std::size_t wanted = std::min(kMaxSamples, count);
    const bool takes = (seen + 1) * wanted / count > seen * wanted / count;
    ++seen;
    if (!takes) continue;
    const Eigen::Vector3d uvd(p.previous_left.u_px, p.previous_left.v_px,
                              p.previous_stereo.disparity_px);
    samples_.push_back({triangulate(camera_, uvd), normalised(camera_, p.left)});
  }
}

// One Gauss-Newton step on reprojection errors weighted by S. Geman and D. McClure (1987):
// w = (s^2 / (s^2 + r^2))^2.
void RigMotion::refine(double scale, Eigen::Isometry3d& T) const {
  Matrix6d H = 1e-9 * Matrix6d::Identity();
  Vector6d b = Vector6d::Zero();
  for (const Sample& s : samples_) {
    const Eigen::Vector3d Q = T * s.P_m;
    if (Q.z() < kMinDepth_m) continue;
    const double k = 1.0 / Q.z(), x = Q.x() * k, y = Q.y() * k;
    const Eigen::Vector2d r(s.seen.x() - x, s.seen.y() - y);
    const double root = scale * scale / (scale * scale + r.squaredNorm());
    Eigen::Matrix<double, 2, 6> J;
    J << k, 0, -x * k, -x * y, 1 + x * x, -y, 0, k, -y * k, -1 - y * y, x * y, x;
    H.noalias() += root * root * J.transpose() * J;
    b.noalias() += root * root * J.transpose() * r;
  }
  const Vector6d xi = H.ldlt().solve(b);
  if (xi.allFinite()) T = se3_exp(xi) * T;
}

double RigMotion::share_near(const Eigen::Isometry3d& T) const {
  const auto near = std::count_if(samples_.begin(), samples_.end(), [&](const Sample& s) {
    const Eigen::Vector3d Q = T * s.P_m;
    return Q.z() > kMinDepth_m && (Q.hnormalized() - s.seen).norm() * camera_.fx_px < kNear_px;
  });
  return static_cast<double>(near) / static_cast<double>(samples_.size());
}

bool RigMotion::rests(const Eigen::Isometry3d& T) const {
  const double limit = kRest_px / camera_.fx_px;
  const auto moved2 = [&](double sum, const Sample& s) {
    const Eigen::Vector3d Q = T * s.P_m;
    return sum +
           (Q.z() > kMinDepth_m ? (Q.hnormalized() - s.P_m.hnormalized()).squaredNorm() : 1.0);
  };
  const double sum = std::accumulate(samples_.begin(), samples_.end(), 0.0, moved2);
  return sum < limit * limit * static_cast<double>(samples_.size());
}

bool RigMotion::guess(const TrackStore& store) {
  const std::size_t first = known_ ? kFirstOfKnown : 0;
  known_ = false;
  if (camera_.fx_px <= 0.0 || camera_.fy_px <= 0.0 || camera_.baseline_m <= 0.0) return false;
  gather(store);
  if (samples_.size() < kMinSamples) return false;
  Eigen::Isometry3d T = T_current_previous_;
  for (std::size_t k = first; k < kScales_px.size(); ++k) refine(kScales_px[k] / camera_.fx_px, T);
  known_ = share_near(T) >= kMinShareNear;
  if (known_) T_current_previous_ = rests(T) ? Eigen::Isometry3d::Identity() : orthonormalised(T);
  return known_;
}

std::optional<RigMotion::Resting> RigMotion::predict(const FollowedPoint& point) const {
  const float disparity_px = point.previous_stereo.disparity_px;
  if (!known_ || disparity_px < kMinDisparity_px) return {};
  const Eigen::Vector3d uvd(point.previous_left.u_px, point.previous_left.v_px, disparity_px);
  const Eigen::Vector3d Q = T_current_previous_ * triangulate(camera_, uvd);
  if (Q.z() < kMinDepth_m) return {};
  const Eigen::Vector3d now = project(camera_, Q);
  return Resting{.left = {static_cast<float>(now.x()), static_cast<float>(now.y())},
                 .disparity_px = static_cast<float>(now.z())};
}

}  // namespace egomod
