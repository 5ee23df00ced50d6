// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/filter_method.hpp"

#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/core/pair_rate.hpp"
#include "egomod/moving_objects/evidence_gates.hpp"

namespace egomod {
namespace {

constexpr double kMostMisfit = 8.0;      // of a point that may speak for motion
constexpr double kLeastUpdates = 3;      // the first two of them fix position and velocity
constexpr double kOneInterval = 2;       // updates
constexpr double kMostRestMisfit = 1.5;  // 1 is what the noise is scaled to
constexpr double kLeapChi2 = 16.27;      // 99.9 %, 3 dof: a single displacement against rest
constexpr int kConfirmPairs = 2;
constexpr double kRigMemory_s = 0.15;  // one pair at a high rate tells little about the speed
constexpr double kReanchor_px = 0.2;   // a renewed template may step
constexpr double kMinDepth_m = 0.2;
constexpr double kUnmeasuredShare = 0.3;  // standard deviation of a disparity that is not measured
constexpr double kLeastRest_s = 0.3;      // sooner, what moves may look at rest
// A velocity less certain than this in some direction says nothing about "static".
constexpr double kUnobservable_mps = 0.5;

bool is_comparable(const Egomotion& motion) {
  return (motion.status == EstimateStatus::kValid || motion.status == EstimateStatus::kAmbiguous ||
          motion.status == EstimateStatus::kFirst) &&
         is_finite(motion.T_first_current) && motion.covariance_previous_current.allFinite();
}

std::size_t place_of(FilterSlot at) { return at.block * kFilterLanes + at.lane; }

bool is_inlier(const Egomotion& motion, std::size_t track) {
  return track < motion.roles.size() && motion.roles[track] == TrackRole::kInlier;
}

Eigen::Vector3d vector_of(const Lanes (&from)[3], std::size_t lane) {
  return {from[0][lane], from[1][lane], from[2][lane]};
}

Eigen::Matrix3d matrix_of(const Lanes (&lower)[6], std::size_t lane) {
  Eigen::Matrix3d M;
  M << lower[0][lane], lower[1][lane], lower[3][lane],  //
      lower[1][lane], lower[2][lane], lower[4][lane],   //
      lower[3][lane], lower[4][lane], lower[5][lane];
  return M;
}

NoiseKey noise_key(const StereoCamera& camera, const Track& track) {
  return {.depth_m = camera.fx_px * camera.baseline_m / track.current.disparity_px,
          .texture = track.min_eigenvalue,
          .age_pairs = static_cast<double>(track.age)};
}

}  // namespace

FilterMethod::FilterMethod(const MovingObjectsConfig& config)
    : config_(config),
      noise_model_(config.noise_floor_px),
      groups_(config),
      objects_(config, {.moving_chi2 = kMovingChi2,
                        .min_evidence = config.min_evidence,
                        .confirm_evidence = config.confirm_evidence,
                        .confirm_pairs = kConfirmPairs}) {
  points_.reserve(kReservedTracks);
  recent_.reserve(kReservedTracks);
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
                       groups_.find(tracks.camera, points_, rig_velocity_mps_), is_slow_);
  }
  objects_.update(tracks.camera, points_,
                  motion.status == EstimateStatus::kValid && (!is_slow_ || !rest_is_off()));
  objects_.report(objects.objects);
  report_points(tracks, objects.points);
  noise_model_.report(objects.noise);
}

void FilterMethod::filter(const TrackSet& tracks, const Egomotion& motion) {
  const bool anew = motion.reset_count != reset_count_ || motion.exposure <= now_;
  if (anew) {
    filters_.clear();
    now_ = motion.exposure;
    rig_pairs_ = 0;
  }
  reset_count_ = motion.reset_count;
  follow_rig(motion);
  const double interval_s = to_seconds(motion.exposure - now_);
  is_slow_ = is_low_rate(interval_s, interval_s_);
  interval_s_ = interval_s;
  now_ = motion.exposure;
  rig_ = RigPose(motion);
  trails_.begin(now_, anew);
  filters_.align(tracks.tracks);
  recent_.resize(tracks.tracks.size());
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const Track& track = tracks.tracks[i];
    if (track.has_current && is_usable(tracks.camera, track.current, config_.max_depth_m))
      measure(tracks.camera, motion.rows, track, filters_.slot(i));
    if (track.left_only && keeps_to_its_object(i))
      measure_left(tracks.camera, motion.rows, track, filters_.slot(i));
  }
  filters_.step(step_of(tracks.camera));
  standing_chi2_.clear();
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const FilterSlot at = filters_.slot(i);
    if (filters_.measurements(at).is_seen[at.lane] == 0.0) continue;
    const FilterBlock& filters = filters_.filters(at);
    if (filters.updates[at.lane] >= least_updates() && is_inlier(motion, i)) {
      standing_chi2_.push_back(filters.standing_chi2[at.lane]);
      learn_noise(tracks.camera, tracks.tracks[i], at);
    }
  }
  noise_.learn(standing_chi2_);
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const FilterSlot at = filters_.slot(i);
    if (filters_.measurements(at).is_seen[at.lane] == 0.0) continue;
    PointSample point = sample(at);
    point.track = i;
    point.pixel_px = uvd(tracks.tracks[i].current).head<2>();
    point.left_only = tracks.tracks[i].left_only;
    if (point.moves) {
      const auto& c = tracks.tracks[i].current.covariance_px2;
      point.weak_axis = weak_axis(c[0], c[1], c[3]);
      if (tracks.tracks[i].has_current) recall(tracks.camera, at, point);
    }
    if (point.velocity_mps.allFinite() && std::isfinite(point.chi2)) points_.push_back(point);
  }
  noise_model_.learn(to_seconds(motion.exposure - motion.previous_exposure));
}

// Whether what rests is where it was due: else a single interval tells nothing.
bool FilterMethod::rest_fits() const { return noise_.misfit() < kMostRestMisfit; }

bool FilterMethod::rest_is_off() const { return std::isfinite(noise_.misfit()) && !rest_fits(); }

double FilterMethod::least_updates() const { return is_slow_ ? kOneInterval : kLeastUpdates; }

// Where the point was due errs too, as the mean of what went before: variances grow by that share.
void FilterMethod::learn_noise(const StereoCamera& camera, const Track& track, FilterSlot at) {
  const FilterBlock& filters = filters_.filters(at);
  if (track.reanchored || filters.evidence[at.lane] >= 0.0) return;
  const double before = filters.updates[at.lane] - 1.0;
  const double shrink = std::sqrt(before / (before + 1.0));
  const Lanes(&r_px)[3] = filters_.points(at).standing_residual_px;
  const auto& c = track.current.covariance_px2;
  noise_model_.add(noise_key(camera, track), {.u_px = shrink * r_px[0][at.lane],
                                              .v_px = shrink * r_px[1][at.lane],
                                              .disparity_px = shrink * r_px[2][at.lane],
                                              .variance_u_px2 = c[0],
                                              .variance_v_px2 = c[3],
                                              .variance_disparity_px2 = c[5]});
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

FilterStep FilterMethod::step_of(const StereoCamera& camera) const {
  FilterStep step = filter_step(rig_, camera);
  step.disparity_bias_px = config_.disparity_bias_px;
  step.flow_error_share = config_.flow_error_share;
  step.walk_px = config_.walk_px;
  step.prior = prior();
  step.now_ns = now_.count();
  step.is_slow = is_slow_;
  return step;
}

void FilterMethod::measure(const StereoCamera& camera, const RowTiming& rows, const Track& track,
                           FilterSlot at) {
  const StereoObservation& seen = track.current;
  const auto& c = seen.covariance_px2;  // upper triangle
  MeasurementBlock& out = filters_.measurements(at);
  const auto set = [lane = at.lane](Lanes& lanes, double x) { lanes[lane] = x; };
  set(out.is_seen, 1.0);
  const Eigen::Vector3d uvd_px = at_middle_row(camera, uvd(seen), rows);
  for (std::size_t k = 0; k < 3; ++k) set(out.uvd_px[k], uvd_px[static_cast<Eigen::Index>(k)]);
  const double scale = noise_.value();
  const double floor_px2 = config_.noise_floor_px * config_.noise_floor_px;
  set(out.covariance_px2[0], scale * c[0] + floor_px2);
  set(out.covariance_px2[1], scale * c[1]);
  set(out.covariance_px2[2], scale * c[3] + floor_px2);
  set(out.covariance_px2[3], scale * c[2]);
  set(out.covariance_px2[4], scale * c[4]);
  set(out.covariance_px2[5], scale * c[5] + floor_px2);
  set(out.reanchored_px, track.reanchored ? kReanchor_px : 0.0);
  if (!track.has_current) return;
  trails_.add(place_of(at), rig_.T_first_current * triangulate(camera, uvd_px),
              filters_.filters(at).updates[at.lane] == 0.0);
}

// The last disparities before the border, or something nearer, hides a point from the right camera
// may be of that: what they have told of its velocity must agree with its object's.
bool FilterMethod::keeps_to_its_object(std::size_t track) const {
  const FilterSlot at = filters_.slot(track);
  const FilterBlock& filters = filters_.filters(at);
  if (filters.updates[at.lane] < kLeastUpdates || filters.evidence[at.lane] < kMovingEvidence)
    return false;
  const Eigen::Matrix3d R = rig_.T_current_first.linear();
  return objects_.moves_with_owner(
      track, R * vector_of(filters.velocity, at.lane),
      R * matrix_of(filters.velocity_covariance, at.lane) * R.transpose());
}

// Its depth goes on as it went, as good as not measured.
void FilterMethod::measure_left(const StereoCamera& camera, const RowTiming& rows,
                                const Track& track, FilterSlot at) {
  const FilterBlock& filters = filters_.filters(at);
  const double unseen_s = to_seconds(now_ - Nanoseconds(filters.seen_ns[at.lane]));
  const Eigen::Vector3d P_m =
      rig_.T_current_first *
      (vector_of(filters.position, at.lane) + unseen_s * vector_of(filters.velocity, at.lane));
  if (P_m.z() < kMinDepth_m) return;
  const double disparity_px = camera.fx_px * camera.baseline_m / P_m.z();
  Track guessed = track;
  guessed.current.disparity_px = static_cast<float>(disparity_px);
  auto& c = guessed.current.covariance_px2;
  c[2] = c[4] = 0.0F;
  c[5] = static_cast<float>(std::pow(kUnmeasuredShare * disparity_px, 2));
  measure(camera, rows, guessed, at);
}

// As the kernels add it to the variance of a velocity.
double FilterMethod::agility_m2ps3(const FilterBlock& filters, std::size_t lane) const {
  const double speed_mps = vector_of(filters.velocity, lane).norm();
  const double a_mps2 = std::clamp(filters.misfit[lane] / kFittingChi2, 1.0, kMostAgility) *
                        (config_.acceleration_mps2 + config_.manoeuvre_hz * speed_mps);
  return a_mps2 * a_mps2 * kAccelerationTime_s;
}

PointSample FilterMethod::sample(FilterSlot at) const {
  const std::size_t lane = at.lane;
  const FilterBlock& filters = filters_.filters(at);
  const PointBlock& points = filters_.points(at);
  const double updates = filters.updates[lane];
  const double evidence = filters.evidence[lane];
  const bool begins = updates >= kOneInterval && filters.fresh_ns[lane] == filters.seen_ns[lane];
  const bool in_one_interval = is_slow_ && (updates == kOneInterval || begins);
  PointSample point;
  point.position_m = vector_of(points.position_m, lane);
  point.position_covariance_m2 = matrix_of(points.position_covariance_m2, lane);
  point.velocity_mps = vector_of(points.velocity_mps, lane);
  point.velocity_covariance_m2ps2 = matrix_of(points.velocity_covariance_m2ps2, lane);
  const Nanoseconds learnt{filters.seen_ns[lane] - filters.fresh_ns[lane]};
  point.stood = filters.stood[lane] != 0.0 && to_seconds(learnt) >= kLeastRest_s;
  point.learnt_s = point.stood ? 0.0 : to_seconds(learnt);
  point.agility_m2ps3 = agility_m2ps3(filters, lane);
  point.chi2 = points.chi2[lane];
  point.evidence = evidence;
  point.motion_probability = logistic(evidence);
  point.moves = !in_one_interval && updates >= kLeastUpdates && evidence > kMovingEvidence &&
                point.chi2 > kMovingChi2 && filters.misfit[lane] < kMostMisfit;
  point.leaps = in_one_interval && rest_fits() && evidence >= 0.0 && point.chi2 > kMovingChi2 &&
                filters.standing_chi2[lane] > kLeapChi2;
  // Alone it may as well be mismatched; that its neighbours agree tells.
  if (point.leaps) point.evidence = std::max(evidence, kMostPerPair);
  point.moves = point.moves || point.leaps;
  point.stands = (updates >= kLeastUpdates || in_one_interval) && evidence < 0.0;
  return point;
}

void FilterMethod::recall(const StereoCamera& camera, FilterSlot at, PointSample& point) {
  RecentVelocities& recent = recent_[point.track];
  recent = trails_.velocities(place_of(at), rig_.T_current_first.linear());
  const Eigen::Matrix3d J =
      triangulate_jacobian(camera, vector_of(filters_.filters(at).uvd_px, at.lane));
  recent.position_covariance_m2 =
      J * matrix_of(filters_.measurements(at).covariance_px2, at.lane) * J.transpose();
  point.recent = &recent;
}

// What no object bears out must show more.
PointState FilterMethod::state_of(const PointSample& point) const {
  if (point.moves)
    return objects_.owner(point.track) != 0 || point.chi2 > kMovingAloneChi2 ? PointState::kMoving
                                                                             : PointState::kUnknown;
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
                      .motion_probability = static_cast<float>(point.motion_probability),
                      .evidence = static_cast<float>(point.evidence),
                      .chi2 = static_cast<float>(point.chi2)});
  }
}

}  // namespace egomod
