// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/thesis_method.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace egomod {
namespace {

constexpr double kAnyDepth_m = 1e4;

double threshold_of(const MovingObjectsConfig& config, const RayleighClassifier& classifier) {
  if (config.threshold_mps > 0.0) return config.threshold_mps;
  return speed_threshold(classifier, config.decision_probability)
      .value_or(std::numeric_limits<double>::infinity());
}

bool is_outlier(const Egomotion& motion, std::size_t track) {
  return track < motion.roles.size() && motion.roles[track] == TrackRole::kOutlier;
}

Step step_of(const Egomotion& motion) {
  return {.T_current_reference = motion.T_previous_current.inverse(),
          .motion_covariance = motion.covariance_previous_current,
          .duration_s = to_seconds(motion.exposure - motion.previous_exposure)};
}

}  // namespace

ThesisMethod::ThesisMethod(const MovingObjectsConfig& config)
    : config_(config),
      classifier_{config.sigma_static_mps, config.sigma_moving_mps, config.prior_moving},
      threshold_mps_(threshold_of(config, classifier_)) {
  points_.reserve(kReservedTracks);
  moving_.reserve(kReservedTracks);
  bins_.reserve(kReservedTracks);
  object_of_point_.reserve(kReservedTracks);
  members_.reserve(kReservedTracks);
  previous_.reserve(kReservedTracks);
  grouper_.reserve(kReservedTracks);
}

void ThesisMethod::detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects) {
  begin(tracks, motion, objects);
  if (!was_tracked(tracks)) return;
  measure(tracks, motion);    // eqs. 21-25
  decide(motion);             // eqs. 30-33
  group();                    // section IV-C, discretised velocity and proximity
  describe(objects.objects);  // section IV-C, rectangle, centroid, mean motion
  name(tracks.exposure, objects.objects);
  report_points(tracks, objects.points);
}

void ThesisMethod::measure(const TrackSet& tracks, const Egomotion& motion) {
  points_.clear();
  const Step step = step_of(motion);
  if (motion.status != EstimateStatus::kValid || !(step.duration_s > 0.0) ||
      !is_finite(step.T_current_reference)) {
    return;
  }
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const Track& track = tracks.tracks[i];
    if (!track.has_current || !track.has_previous ||
        !is_usable(tracks.camera, track.previous, kAnyDepth_m) ||
        !is_usable(tracks.camera, track.current, kAnyDepth_m)) {
      continue;
    }
    PointSample sample = measure_point(tracks.camera, track.previous, track.current, step);
    sample.track = i;
    if (sample.velocity_mps.allFinite()) points_.push_back(sample);
  }
}

// Only outliers of the odometry's RANSAC are candidates: inliers moved with the static world.
void ThesisMethod::decide(const Egomotion& motion) {
  moving_.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    PointSample& point = points_[i];
    const double speed_mps = point.velocity_mps.norm();
    const bool outlier = is_outlier(motion, point.track);
    point.motion_probability = outlier ? moving_posterior(classifier_, speed_mps) : 0.0;
    point.moves = outlier && speed_mps > threshold_mps_;
    if (point.moves) moving_.push_back(static_cast<Grouper::Index>(i));
  }
}

void ThesisMethod::group() {
  bins_.clear();
  for (const auto i : moving_) {
    bins_.push_back((points_[i].velocity_mps / config_.velocity_bin_mps).array().round());
  }
  const auto position = [this](Grouper::Index i) -> const Eigen::Vector3d& {
    return points_[moving_[i]].position_m;
  };
  grouper_.group(
      moving_.size(), config_.group_distance_m, [&](auto i) { return position(i).x(); },
      [&](auto i, auto j) {
        return (bins_[i] - bins_[j]).cwiseAbs().maxCoeff() <= config_.velocity_bin_reach &&
               (position(i) - position(j)).norm() <= config_.group_distance_m;
      });
}

void ThesisMethod::describe(std::vector<MovingObject>& objects) {
  object_of_point_.assign(points_.size(), 0);
  for (std::size_t g = 0; g < grouper_.size(); ++g) {
    if (grouper_[g].size() < static_cast<std::size_t>(config_.group_min_points)) continue;
    members_.clear();
    for (const auto i : grouper_[g]) members_.push_back(moving_[i]);
    objects.push_back(object_of(members_));
    // Until the object has its name, its points know it by its place in the list.
    for (const auto i : members_) {
      object_of_point_[i] = static_cast<std::int64_t>(objects.size());
    }
  }
}

MovingObject ThesisMethod::object_of(Members members) const {
  MovingObject object;
  object.state = ObjectState::kMoving;
  object.position_m = mean_position(points_, members);
  object.velocity_mps = mean_velocity(points_, members);
  object.rectangle = rectangle_of(points_, members);
  object.extent_m = extent_of(points_, members);
  object.points = static_cast<int>(members.size());
  const double rho = config_.error_correlation;
  object.position_covariance_m2 =
      mean_covariance(points_, members, rho, &PointSample::position_covariance_m2);
  object.velocity_covariance_m2ps2 =
      mean_covariance(points_, members, rho, &PointSample::velocity_covariance_m2ps2);
  set_speed(object);
  object.motion_probability = moving_posterior(classifier_, object.speed_mps);
  return object;
}

// An object takes over the name of the group of the previous pair that it overlaps most.
void ThesisMethod::name(Nanoseconds exposure, std::vector<MovingObject>& objects) {
  const double elapsed_s = to_seconds(exposure - previous_exposure_);
  for (MovingObject& object : objects) {
    Previous* best = nullptr;
    for (Previous& previous : previous_) {
      const float shared_px2 = intersection_px2(object.rectangle, previous.rectangle);
      if (previous.id != 0 && shared_px2 > 0.0F &&
          (best == nullptr || shared_px2 > intersection_px2(object.rectangle, best->rectangle))) {
        best = &previous;
      }
    }
    object.id = best != nullptr ? best->id : ++last_id_;
    object.age_s = best != nullptr ? best->age_s + elapsed_s : 0.0;
    if (best != nullptr) best->id = 0;
  }
  previous_.clear();
  for (const MovingObject& object : objects) {
    previous_.push_back({object.id, object.rectangle, object.age_s});
  }
  previous_exposure_ = exposure;
}

void ThesisMethod::report_points(const TrackSet& tracks, std::vector<PointMotion>& points) const {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const PointSample& point = points_[i];
    const std::int64_t place = object_of_point_[i];
    points.push_back(
        {.track_id = tracks.tracks[point.track].id,
         .state = point.moves ? PointState::kMoving : PointState::kStatic,
         .object_id = place == 0 ? 0 : previous_[static_cast<std::size_t>(place - 1)].id,
         .position_m = point.position_m,
         .velocity_mps = point.velocity_mps,
         .motion_probability = static_cast<float>(point.motion_probability)});
  }
}

}  // namespace egomod
