// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/lag_method.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

constexpr std::size_t kMostReferences = 32;
// A velocity less certain than this in some direction says nothing about "static".
constexpr double kUnobservable_mps = 0.5;

bool is_comparable(const Egomotion& motion) {
  return (motion.status == EstimateStatus::kValid || motion.status == EstimateStatus::kAmbiguous ||
          motion.status == EstimateStatus::kFirst) &&
         is_finite(motion.T_first_current) && is_finite(motion.T_previous_current) &&
         motion.covariance_previous_current.allFinite();
}

bool is_inlier(const Egomotion& motion, std::size_t track) {
  return track < motion.roles.size() && motion.roles[track] == TrackRole::kInlier;
}

}  // namespace

LagMethod::LagMethod(const MovingObjectsConfig& config)
    : config_(config),
      history_(config),
      groups_(config),
      objects_(config, {.min_speed_mps = config.min_speed_mps,
                        .moving_chi2 = config.moving_chi2,
                        .confirm_pairs = config.confirm_pairs,
                        .confirm_s = config.confirm_s}) {
  cursors_.reserve(kMostReferences);
  steps_.reserve(kMostReferences);
  points_.reserve(kReservedTracks);
  inlier_chi2_.reserve(kReservedTracks);
}

void LagMethod::detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects) {
  begin(tracks, motion, objects);
  if (!objects.has_run) return;
  if (!was_tracked(tracks)) {
    objects_.miss(tracks);
    return objects_.report(objects.objects);
  }
  points_.clear();
  objects_.predict(tracks, motion);
  if (is_comparable(motion)) {
    history_.advance(motion);
    measure(tracks, motion);
    scale_noise(motion);
    decide();
    objects_.associate(tracks.camera, points_, groups_,
                       groups_.find(tracks.camera, points_, rig_velocity(motion)));
    history_.push(tracks, motion);
  }
  objects_.update(tracks.camera, points_, motion.status == EstimateStatus::kValid);
  objects_.report(objects.objects);
  report_points(tracks, objects.points);
}

// Each track against the pair nearest to the lag that saw it.
void LagMethod::measure(const TrackSet& tracks, const Egomotion& motion) {
  cursors_.clear();
  steps_.clear();
  for (const LagHistory::Entry* entry : history_.references(motion.exposure)) {
    cursors_.emplace_back(*entry);
    steps_.push_back(
        {.T_current_reference = motion.T_first_current.inverse() * entry->T_first_entry,
         .motion_covariance = entry->motion_covariance,
         .duration_s = to_seconds(motion.exposure - entry->exposure),
         .floor_px = config_.noise_floor_px,
         .disparity_bias_px = config_.disparity_bias_px,
         .flow_error_share = config_.flow_error_share});
  }
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const Track& track = tracks.tracks[i];
    if (!track.has_current || !is_usable(tracks.camera, track.current, config_.max_depth_m)) {
      continue;
    }
    for (std::size_t k = 0; k < cursors_.size(); ++k) {
      const StereoObservation* reference = cursors_[k].find(track.id);
      if (reference == nullptr || !is_usable(tracks.camera, *reference, config_.max_depth_m)) {
        continue;
      }
      PointSample point = measure_point(tracks.camera, *reference, track.current, steps_[k]);
      point.track = i;
      if (std::isfinite(point.chi2) && point.velocity_mps.allFinite()) points_.push_back(point);
      break;
    }
  }
}

// Covariances rank well and are off by a common factor; the static world tells which.
void LagMethod::scale_noise(const Egomotion& motion) {
  inlier_chi2_.clear();
  for (const PointSample& point : points_) {
    if (is_inlier(motion, point.track)) inlier_chi2_.push_back(point.chi2 / noise_.value());
  }
  noise_.learn(inlier_chi2_);
  for (PointSample& point : points_) {
    point.chi2 /= noise_.value();
    point.velocity_covariance_m2ps2 *= noise_.value();
    point.position_covariance_m2 *= noise_.value();
  }
}

void LagMethod::decide() {
  for (PointSample& point : points_) {
    point.moves =
        point.chi2 > config_.moving_chi2 && point.velocity_mps.norm() > config_.min_speed_mps;
    point.stands = !point.moves && point.chi2 < config_.static_chi2;
    point.evidence = motion_log_ratio(point.velocity_mps, point.velocity_covariance_m2ps2,
                                      config_.velocity_prior_mps);
    point.motion_probability = logistic(point.evidence);
  }
}

PointState LagMethod::state_of(const PointSample& point) const {
  if (point.moves) return PointState::kMoving;
  const double widest = point.velocity_covariance_m2ps2.diagonal().maxCoeff();
  if (widest > kUnobservable_mps * kUnobservable_mps) return PointState::kUnobservable;
  return point.stands ? PointState::kStatic : PointState::kUnknown;
}

void LagMethod::report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const {
  for (const PointSample& point : points_) {
    points.push_back({.track_id = tracks.tracks[point.track].id,
                      .state = state_of(point),
                      .object_id = objects_.owner(point.track),
                      .position_m = point.position_m,
                      .velocity_mps = point.velocity_mps,
                      .motion_probability = static_cast<float>(point.motion_probability),
                      .evidence = static_cast<float>(point.evidence),
                      .chi2 = static_cast<float>(point.chi2)});
  }
}

}  // namespace egomod
