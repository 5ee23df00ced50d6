// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/filter_method.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kMovingEvidence = 2.0;
constexpr double kMovingChi2 = 11.34;  // 99 %, 3 dof: its velocity against rest
constexpr double kMostMisfit = 8.0;    // of a point that may speak for motion
constexpr int kLeastUpdates = 3;       // the first two of them fix position and velocity
constexpr int kConfirmPairs = 2;
constexpr double kRigMemory_s = 0.15;  // one pair at a high rate tells little about the speed
constexpr double kReanchor_px = 0.2;   // a renewed template may step
// A velocity less certain than this in some direction says nothing about "static".
constexpr double kUnobservable_mps = 0.5;
constexpr double kLeastDepthShare = 0.5;  // nearer or further than that from the prediction the
constexpr double kMostDepthShare = 2.0;   // measurement itself is the better point to linearise at

bool is_comparable(const Egomotion& motion) {
  return (motion.status == EstimateStatus::kValid || motion.status == EstimateStatus::kAmbiguous ||
          motion.status == EstimateStatus::kFirst) &&
         is_finite(motion.T_first_current) && motion.covariance_previous_current.allFinite();
}

bool is_inlier(const Egomotion& motion, std::size_t track) {
  return track < motion.roles.size() && motion.roles[track] == TrackRole::kInlier;
}

// Where the filters expect the point, if that is any better than where it is measured.
Eigen::Vector3d expected_px(const StereoCamera& camera, const RigPose& rig,
                            const TrackFilter& filter, const Eigen::Vector3d& measured_px) {
  if (filter.updates == 0 || filter.is_young()) return measured_px;
  const Eigen::Vector3d P_m = rig.T_current_first * filter.position_m();
  const double disparity_px = camera.fx_px * camera.baseline_m / P_m.z();
  if (disparity_px < kLeastDepthShare * measured_px.z() ||
      disparity_px > kMostDepthShare * measured_px.z()) {
    return measured_px;
  }
  return project(camera, P_m);
}

}  // namespace

FilterMethod::FilterMethod(const MovingObjectsConfig& config)
    : config_(config),
      groups_(config),
      objects_(config, {.min_evidence = config.min_evidence,
                        .confirm_evidence = config.confirm_evidence,
                        .confirm_pairs = kConfirmPairs}) {
  points_.reserve(kReservedTracks);
  standing_chi2_.reserve(kReservedTracks);
}

void FilterMethod::detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects) {
  begin(tracks, motion, objects);
  if (!objects.has_run) return;
  if (!was_tracked(tracks)) {
    objects_.miss(tracks);
    return objects_.report(objects.objects);
  }
  points_.clear();
  objects_.predict(tracks, motion);
  if (is_comparable(motion)) {
    filter(tracks, motion);
    objects_.associate(tracks.camera, points_, groups_,
                       groups_.find(tracks.camera, points_, rig_velocity_mps_));
  }
  objects_.update(tracks.camera, points_, motion.status == EstimateStatus::kValid);
  objects_.report(objects.objects);
  report_points(tracks, objects.points);
}

void FilterMethod::filter(const TrackSet& tracks, const Egomotion& motion) {
  if (motion.reset_count != reset_count_ || motion.exposure <= now_) {
    filters_.clear();
    now_ = motion.exposure;
    rig_pairs_ = 0;
  }
  reset_count_ = motion.reset_count;
  follow_rig(motion);
  now_ = motion.exposure;
  rig_ = RigPose(motion);
  filters_.align(tracks.tracks);
  const MotionPrior motion_prior = prior();
  standing_chi2_.clear();
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const Track& track = tracks.tracks[i];
    filters_.prefetch(i + 1);
    if (!track.has_current || !is_usable(tracks.camera, track.current, config_.max_depth_m)) {
      continue;
    }
    TrackFilter& filter = filters_.of(i);
    if (filter.updates > 0) filter.predict(motion_prior, now_);
    const PointMeasurement measurement = measure(tracks.camera, track, filter);
    if (filter.updates > 0) {
      filter.update(measurement, motion_prior);
      if (!filter.is_young() && is_inlier(motion, i)) {
        standing_chi2_.push_back(filter.standing_chi2);
      }
    } else {
      filter.start(measurement, motion_prior, now_);
    }
    filter.uvd_px = uvd(track.current);
    PointSample point = sample(filter);
    point.track = i;
    if (point.velocity_mps.allFinite() && std::isfinite(point.chi2)) points_.push_back(point);
  }
  noise_.learn(standing_chi2_);
}

void FilterMethod::follow_rig(const Egomotion& motion) {
  if (motion.status != EstimateStatus::kValid) return;
  const double fresh = -std::expm1(-to_seconds(motion.exposure - now_) / kRigMemory_s);
  const double gain = std::max(fresh, 1.0 / ++rig_pairs_);
  rig_velocity_mps_ += gain * (rig_velocity(motion) - rig_velocity_mps_);
}

// Rigs that are fast live among things that are.
MotionPrior FilterMethod::prior() const {
  return {.velocity_mps = std::hypot(config_.velocity_prior_mps, rig_velocity_mps_.norm()),
          .acceleration_mps2 = config_.acceleration_mps2,
          .manoeuvre_hz = config_.manoeuvre_hz};
}

PointMeasurement FilterMethod::measure(const StereoCamera& camera, const Track& track,
                                       const TrackFilter& filter) const {
  const Eigen::Vector3d z_px = uvd(track.current);
  const Eigen::Vector3d at_px = expected_px(camera, rig_, filter, z_px);
  const Eigen::Matrix3d J = triangulate_jacobian(camera, at_px);
  const Eigen::Matrix3d G = rig_.T_first_current.linear() * J;
  Eigen::Matrix3d R_px2 = noise_.value() * covariance(track.current);
  R_px2.diagonal().array() += config_.noise_floor_px * config_.noise_floor_px;

  const double path_px = filter.updates > 0 ? (z_px - filter.uvd_px).norm() : 0.0;
  const double stretch_px = config_.flow_error_share * path_px;
  const double wander_px = std::sqrt(config_.walk_px * config_.walk_px + stretch_px * stretch_px) +
                           (track.reanchored ? kReanchor_px : 0.0);

  PointMeasurement m;
  m.position_m = rig_.T_first_current * triangulate(camera, at_px);
  m.covariance_m2.noalias() = G * R_px2 * G.transpose();
  m.covariance_m2 += rig_.covariance_at(m.position_m - rig_.T_first_current.translation());
  m.position_m.noalias() += G * (z_px - at_px);
  const Eigen::Vector3d walk_px2{wander_px * wander_px, wander_px * wander_px,
                                 stretch_px * stretch_px};
  m.walk_m2.noalias() = G * walk_px2.asDiagonal() * G.transpose();
  m.bias_m = config_.disparity_bias_px * G.col(2);
  m.volume_m3 = std::abs(J.determinant());
  return m;
}

PointSample FilterMethod::sample(const TrackFilter& filter) const {
  const Eigen::Matrix3d R = rig_.T_current_first.linear();
  PointSample point;
  point.position_m = rig_.T_current_first * filter.position_m();
  point.position_covariance_m2 = R * filter.moving.covariance.topLeftCorner<3, 3>() * R.transpose();
  point.velocity_mps = R * filter.velocity_mps();
  const Eigen::Matrix3d Cv = filter.moving.covariance.bottomRightCorner<3, 3>();
  point.velocity_covariance_m2ps2 = R * Cv * R.transpose();
  point.chi2 = filter.velocity_mps().dot(Cv.inverse() * filter.velocity_mps());
  point.evidence = filter.evidence;
  point.motion_probability = logistic(filter.evidence);
  point.moves = filter.updates >= kLeastUpdates && filter.evidence > kMovingEvidence &&
                point.chi2 > kMovingChi2 && filter.misfit < kMostMisfit;
  point.stands = filter.updates >= kLeastUpdates && filter.evidence < 0.0;
  point.pixel_px = filter.uvd_px.head<2>();
  return point;
}

PointState FilterMethod::state_of(const PointSample& point) const {
  if (point.moves) return PointState::kMoving;
  const double widest = point.velocity_covariance_m2ps2.diagonal().maxCoeff();
  if (widest > kUnobservable_mps * kUnobservable_mps) return PointState::kUnobservable;
  return point.stands ? PointState::kStatic : PointState::kUnknown;
}

void FilterMethod::report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const {
  for (const PointSample& point : points_) {
    points.push_back({.track_id = tracks.tracks[point.track].id,
                      .state = state_of(point),
                      .object_id = objects_.owner(point.track),
                      .position_m = point.position_m,
                      .velocity_mps = point.velocity_mps,
                      .motion_probability = static_cast<float>(point.motion_probability)});
  }
}

}  // namespace egomod
