// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/recent_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace egomod {
namespace {

constexpr double kLeastPoints = 5.0;
constexpr double kCommonShare = 0.1;  // of a point's variance: subpixel errors that all points make
constexpr double kAgreeChi2 = 6.0;
constexpr double kProvenChi2 = 8.0;  // the most that noise alone is taken to make
constexpr double kLagShare = 0.75;  // of a window, that its velocity lags: half of it, and a margin

struct Window {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2ps2 = Eigen::Matrix3d::Zero();
  double count = 0.0;  // of points
};

// By the scatter of the points and by what noise is expected of them: few points may agree by
// chance.
Window mean_over(std::size_t k, std::span<const PointSample> points, Members members,
                 const BodyMotion& body, const Eigen::Vector3d& at_m,
                 const Eigen::Matrix3d& acceleration_m2ps4) {
  Window window;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double span_s = 0.0;
  for (const auto i : members) {
    const RecentVelocities* recent = points[i].recent;
    if (recent == nullptr || recent->count <= k) continue;
    const RecentVelocities::Window& own = recent->windows[k];
    const Eigen::Vector3d velocity_mps =
        own.velocity_mps - body.angular_velocity_radps.cross(points[i].position_m - at_m);
    window.velocity_mps += velocity_mps;
    squares += velocity_mps * velocity_mps.transpose();
    noise += own.gain_hz2 * recent->position_covariance_m2;
    span_s = own.span_s;
    ++window.count;
  }
  if (window.count < kLeastPoints) return window;
  const double n = window.count;
  const Eigen::Vector3d mean_mps = window.velocity_mps / n;
  const Eigen::Matrix3d scatter = (squares - n * mean_mps * mean_mps.transpose()) / (n - 3.0);
  const double lag_s = kLagShare * span_s;
  window.velocity_mps = mean_mps;
  window.covariance_m2ps2 =
      (kCommonShare + 1.0 / n) * noise / n + scatter / n + lag_s * lag_s * acceleration_m2ps4;
  return window;
}

double chi2(const Eigen::Vector3d& x, const Eigen::Matrix3d& information) {
  return x.dot(information * x);
}

}  // namespace

RecentMotion fit_recent_motion(std::span<const PointSample> points, Members members,
                               const BodyMotion& body, const Eigen::Vector3d& at_m,
                               const Eigen::Vector3d& velocity_mps,
                               const Eigen::Matrix3d& acceleration_m2ps4) {
  RecentMotion best;
  std::array<Eigen::Vector3d, kRecentPairs.size()> ahead_mps;
  std::array<Eigen::Matrix3d, kRecentPairs.size()> information;
  double most = 0.0;
  for (std::size_t k = 0; k < kRecentPairs.size(); ++k) {
    const Window window = mean_over(k, points, members, body, at_m, acceleration_m2ps4);
    if (window.count < kLeastPoints) break;
    ahead_mps[k] = window.velocity_mps - velocity_mps;
    information[k] = window.covariance_m2ps2.inverse();
    bool agrees = true;
    for (std::size_t j = 0; j < k; ++j)
      agrees = agrees && chi2(ahead_mps[k] - ahead_mps[j], information[j]) < kAgreeChi2;
    if (!agrees) break;
    most = std::max(most, chi2(ahead_mps[k], information[k]));
    if (k == 0 || window.covariance_m2ps2.trace() < best.covariance_m2ps2.trace()) {
      best.ahead_mps = ahead_mps[k];
      best.covariance_m2ps2 = window.covariance_m2ps2;
    }
  }
  if (most > kProvenChi2) best.proven = 1.0 - kProvenChi2 / most;
  return best;
}

void take(const RecentMotion& recent, const Eigen::Matrix3d& start_m2ps2,
          Eigen::Vector3d& velocity_mps, Eigen::Matrix3d& manoeuvres_m2ps2) {
  if (recent.covariance_m2ps2.trace() <= 0.0) return;
  const Eigen::Matrix3d change =
      recent.proven * recent.ahead_mps * recent.ahead_mps.transpose() + start_m2ps2;
  const auto gain = [&](const Eigen::Matrix3d& prior) -> Eigen::Matrix3d {
    return prior * (prior + recent.covariance_m2ps2).inverse();
  };
  const Eigen::Vector3d taken_mps = gain(change) * recent.ahead_mps;
  const Eigen::Matrix3d prior = manoeuvres_m2ps2 + change;
  const Eigen::Matrix3d K = gain(prior);
  const Eigen::Vector3d left_mps = K * recent.ahead_mps - taken_mps;
  velocity_mps += taken_mps;
  manoeuvres_m2ps2 = prior - K * prior + left_mps * left_mps.transpose();
}

}  // namespace egomod
