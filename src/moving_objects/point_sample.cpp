// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/point_sample.hpp"

#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kWeakRatio = 1.4;  // of standard errors

}  // namespace

Eigen::Vector2d weak_axis(double uu_px2, double uv_px2, double vv_px2) {
  const double half_px2 = 0.5 * (uu_px2 - vv_px2);
  const double spread_px2 = std::hypot(half_px2, uv_px2);
  const double mean_px2 = 0.5 * (uu_px2 + vv_px2);
  if (mean_px2 + spread_px2 <= kWeakRatio * kWeakRatio * (mean_px2 - spread_px2))
    return Eigen::Vector2d::Zero();
  const double angle_rad = 0.5 * std::atan2(uv_px2, half_px2);
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

bool is_usable(const StereoCamera& camera, const StereoObservation& observation,
               double max_depth_m) {
  const auto& c = observation.covariance_px2;
  return std::isfinite(observation.u_px) && std::isfinite(observation.v_px) &&
         std::isfinite(observation.disparity_px) &&
         observation.disparity_px * max_depth_m > camera.fx_px * camera.baseline_m &&
         std::all_of(c.begin(), c.end(), [](float x) { return std::isfinite(x); }) &&
         c[0] >= 0.0F && c[3] >= 0.0F && c[5] >= 0.0F;
}

Residual static_residual(const StereoCamera& camera, const StereoObservation& reference,
                         const StereoObservation& current, const Step& step) {
  const Eigen::Vector3d predicted_m =
      step.T_current_reference * triangulate(camera, uvd(reference));
  const Eigen::Matrix3d J = project_jacobian(camera, predicted_m);
  const Eigen::Matrix3d H =
      J * step.T_current_reference.linear() * triangulate_jacobian(camera, uvd(reference));
  const Eigen::Matrix3d floor_px2 = step.floor_px * step.floor_px * Eigen::Matrix3d::Identity();

  Residual residual;
  residual.value_px = uvd(current) - project(camera, predicted_m);
  // A point is predicted at Exp(-xi) * P, so dP/dxi = [-I, skew(P)]; the residual falls as the
  // prediction grows.
  residual.motion_jacobian.leftCols<3>() = J;
  residual.motion_jacobian.rightCols<3>().noalias() = -J * skew(predicted_m);
  const Eigen::Vector3d bias_px =
      step.disparity_bias_px * (Eigen::Vector3d::UnitZ() - H * Eigen::Vector3d::UnitZ());
  const double path_error_px =
      step.flow_error_share * (uvd(current) - residual.value_px - uvd(reference)).norm();
  const Eigen::Matrix<double, 3, 6> JS = residual.motion_jacobian * step.motion_covariance;
  residual.covariance_px2 =
      covariance(current) + floor_px2 + H * (covariance(reference) + floor_px2) * H.transpose() +
      JS * residual.motion_jacobian.transpose() +
      path_error_px * path_error_px * Eigen::Matrix3d::Identity() + bias_px * bias_px.transpose();
  return residual;
}

PointSample measure_point(const StereoCamera& camera, const StereoObservation& reference,
                          const StereoObservation& current, const Step& step) {
  const Residual residual = static_residual(camera, reference, current, step);
  const Eigen::Matrix3d J = triangulate_jacobian(camera, uvd(current));
  const double rate_hz = 1.0 / step.duration_s;
  // Thesis eq. 23: where a static point would be now.
  const Eigen::Vector3d predicted_m =
      step.T_current_reference * triangulate(camera, uvd(reference));

  PointSample sample;
  sample.pixel_px = uvd(current).head<2>();
  sample.position_m = triangulate(camera, uvd(current));
  sample.position_covariance_m2 = J * covariance(current) * J.transpose();
  sample.velocity_mps = (sample.position_m - predicted_m) * rate_hz;  // thesis eq. 24
  sample.velocity_covariance_m2ps2 =
      rate_hz * rate_hz * J * residual.covariance_px2 * J.transpose();
  sample.chi2 = residual.value_px.dot(residual.covariance_px2.inverse() * residual.value_px);
  return sample;
}

double motion_log_ratio(const Eigen::Vector3d& velocity_mps,
                        const Eigen::Matrix3d& covariance_m2ps2, double prior_mps) {
  const Eigen::Matrix3d wide =
      covariance_m2ps2 + prior_mps * prior_mps * Eigen::Matrix3d::Identity();
  const double chi2_static = velocity_mps.dot(covariance_m2ps2.inverse() * velocity_mps);
  const double chi2_moving = velocity_mps.dot(wide.inverse() * velocity_mps);
  return 0.5 * (chi2_static - chi2_moving +
                std::log(covariance_m2ps2.determinant() / wide.determinant()));
}

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }

bool was_tracked(const TrackSet& tracks) {
  return tracks.pair_status == PairStatus::kOk && tracks.status != TrackStatus::kNotRun;
}

bool is_finite(const Eigen::Isometry3d& T) { return T.matrix().allFinite(); }

Eigen::Vector3d rig_velocity(const Egomotion& motion) {
  const double dt_s = to_seconds(motion.exposure - motion.previous_exposure);
  const Eigen::Vector3d moved_m =
      motion.T_previous_current.linear().transpose() * motion.T_previous_current.translation();
  const bool known = motion.status == EstimateStatus::kValid && dt_s > 0.0 && moved_m.allFinite();
  return known ? Eigen::Vector3d(moved_m / dt_s) : Eigen::Vector3d::Zero();
}

void begin(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects) {
  objects.sequence = tracks.sequence;
  objects.exposure = tracks.exposure;
  objects.has_run = motion.status != EstimateStatus::kSkipped;
  objects.objects.clear();
  objects.objects.reserve(kReservedObjects);
  objects.noise.clear();
  objects.noise.reserve(kReservedNoiseBins);
  objects.points.clear();
  objects.points.reserve(std::max(kReservedTracks, tracks.tracks.size()));
}

}  // namespace egomod
