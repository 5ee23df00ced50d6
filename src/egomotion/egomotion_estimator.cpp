// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/egomotion_estimator.hpp"

#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/degeneracy.hpp"

namespace egomod {
namespace {

constexpr double kMinDtS = 1e-3;
constexpr double kHabitS = 0.5;
constexpr double kNoiseScaleRate = 0.15;
constexpr double kMinNoiseScale = 0.3;
constexpr double kMaxNoiseScale = 12.0;
constexpr double kMinNoiseRatio = 0.2;  // of one pair: images that repeat have no noise at all
constexpr double kTrusted = 0.5;        // static weight of tracks that tell the noise
constexpr std::size_t kTracksThatTellNoise = 20;
constexpr std::size_t kMinCorrespondences = 4;
constexpr std::size_t kTracksToStartAnew = 20;
// Slower rigs show nothing of the rows.
constexpr double kRestMps = 0.02;
constexpr double kRestRadps = 0.01;
constexpr int kMostSolutionsForRows = 5;
constexpr double kSameVelocity = 2e-3;        // m/s or rad/s
constexpr double kScaleOfHalfQuality = 0.02;  // standard deviation
constexpr double kShareInDoubt = 0.5;
constexpr int kMaxAmbiguousQuality = 20;
constexpr double kInliersOfFullQuality = 100.0;
// Of the tracks: so many that are known to stand still, or without a map so many that move as one,
// outweigh wheels.
constexpr double kKnownShare = 0.4;
constexpr double kExplainedShare = 0.8;
// A map that contradicts this many pairs in a row is wrong itself; a young one, begun on a blurred
// image perhaps, sooner: it earns each of them by as many pairs that it explains.
constexpr int kMostContradictedPairs = 3;
constexpr int kPairsThatEarnOne = 3;
// A mover that has moved from the first pair on pulls at the first motions, until it has gone far
// enough to be told: the map does not take them up.
constexpr double kHeldS = 0.19;

}  // namespace

EgomotionEstimator::EgomotionEstimator(const EgomotionConfig& config)
    : config_(config),
      gauss_newton_(config.gauss_newton, config.ransac),
      sigma_point_(config.sigma_point_filter, config.ransac),
      rival_finder_(config.rival, config.gauss_newton, config.ransac),
      wheels_prior_(config.wheels),
      map_(config.track_map),
      velocity_(unknown_velocity()),
      habit_(velocity_) {}

void EgomotionEstimator::estimate(const TrackSet& tracks, Egomotion& motion) {
  begin(tracks, motion);
  watch_for_holes(tracks);
  if (tracks.status == TrackStatus::kNotRun) return repeat_pose(tracks, motion);
  const EstimateReason anew = reason_to_start_anew(tracks);
  if (!started_ || anew != EstimateReason::kNone) {
    start_anew(anew, tracks, motion);
  } else {
    follow(tracks, motion);
  }
  finish(motion);
  camera_ = tracks.camera;
  last_tracked_sequence_ = tracks.sequence;
  skipped_ = 0;
}

EstimateReason EgomotionEstimator::reason_to_start_anew(const TrackSet& tracks) const {
  if (started_ && (tracks.camera != camera_ || tracks.right_turn.has_changed))
    return EstimateReason::kRecalibrated;
  const bool reseeded = tracks.status == TrackStatus::kReseeded ||
                        tracks.status == TrackStatus::kFirst ||
                        (is_lost_ && tracks.status == TrackStatus::kOk);
  return reseeded ? EstimateReason::kReseeded : EstimateReason::kNone;
}

void EgomotionEstimator::follow(const TrackSet& tracks, Egomotion& motion) {
  advance_to(tracks, motion);
  if (after_hole_) pair_velocity_.clear();
  rows_ = {readout_.readout_s(), pair_velocity_.after(velocity_.y)};
  gather(tracks);
  if (is_cut_off(tracks)) return start_anew(EstimateReason::kReseeded, tracks, motion);
  Solution solution = solve(tracks);
  account_for_rows(tracks, solution);
  assign_roles(tracks, solution, motion);
  const EstimateReason failure = judge(solution, motion);
  if (failure != EstimateReason::kNone) {
    fail(failure, tracks, motion);
    // A map that is given up for its contradictions need not wait for the next pair, where enough
    // is seen that it does not know; one that has explained nothing yet was begun by a bad pair
    // too.
    if (!config_.map || !is_lost_ || explained_pairs_ == 0 || tracks.status != TrackStatus::kOk ||
        unknown_tracks(tracks) < kTracksToStartAnew)
      return;
    begin(tracks, motion);
    return start_anew(EstimateReason::kReseeded, tracks, motion);
  }
  note_common_error();
  Solution other;
  const bool has_rival = weigh_rival(tracks, solution, other, motion);
  const bool contradicted = wheels_contradict(solution, motion);
  accept(tracks, solution, has_rival, contradicted, motion);
  if (has_rival) {
    doubt(other, EstimateReason::kMoverDominates, motion);
  } else if (contradicted) {
    doubt({wheels_->T_previous_current, wheels_->covariance}, EstimateReason::kWheelsContradict,
          motion);
  } else {
    to_other_pose_.setZero();
  }
}

void EgomotionEstimator::begin(const TrackSet& tracks, Egomotion& motion) const {
  std::vector<TrackRole> roles = std::move(motion.roles);
  motion = Egomotion{};
  motion.roles = std::move(roles);
  motion.roles.assign(tracks.tracks.size(), TrackRole::kUnused);
  motion.sequence = tracks.sequence;
  motion.exposure = tracks.exposure;
  motion.previous_exposure = started_ ? reference_exposure_ : tracks.exposure;
}

void EgomotionEstimator::finish(Egomotion& motion) const {
  motion.T_first_current = pose_.T_first_current();
  motion.covariance_first_current = pose_.covariance() + against_map_;
  // What the pose does not know of yet, or what the next motion will take in.
  if (motion.status == EstimateStatus::kFailed &&
      (config_.map || motion.reason == EstimateReason::kPairRejected))
    motion.covariance_first_current += motion.covariance_previous_current;
  motion.reset_count = pose_.reset_count();
}

void EgomotionEstimator::repeat_pose(const TrackSet& tracks, Egomotion& motion) {
  const bool skipped = tracks.pair_status == PairStatus::kSkipped;
  skipped_ += skipped ? 1 : 0;
  motion.status = skipped ? EstimateStatus::kSkipped : EstimateStatus::kFailed;
  motion.reason = skipped ? EstimateReason::kNone : EstimateReason::kPairRejected;
  if (!skipped) motion.covariance_previous_current = unknown_motion();
  finish(motion);
}

void EgomotionEstimator::start_anew(EstimateReason reason, const TrackSet& tracks,
                                    Egomotion& motion) {
  motion.status = EstimateStatus::kFirst;
  motion.previous_exposure = tracks.exposure;
  if (started_) {
    motion.reason = reason;
    pose_.reset(unknown_motion());
  }
  started_ = true;
  start_exposure_ = tracks.exposure;
  is_lost_ = false;
  after_hole_ = false;
  contradicted_pairs_ = 0;
  explained_pairs_ = 0;
  has_velocity_ = false;
  velocity_ = habit_ = unknown_velocity();
  against_map_.setZero();
  to_other_pose_.setZero();
  rival_finder_.reset();
  // The new map's first points come before any velocity is known to take their rows to one time.
  if (reason == EstimateReason::kRecalibrated || readout_.readout_s() > 0.0) readout_ = {};
  pair_velocity_.clear();
  is_first_motion_ = true;
  error_of_readout_.clear();
  scale_doubt_.clear();
  rows_ = {};
  map_.clear();
  map_.align(tracks.tracks, 0.0);
  map_.update(tracks.camera, tracks.tracks, pose_.T_first_current(), Matrix6d::Zero(),
              noise_scale_);
  reference_exposure_ = map_exposure_ = tracks.exposure;
  wheels_prior_.begin_at(tracks);
}

void EgomotionEstimator::advance_to(const TrackSet& tracks, Egomotion& motion) {
  if (!config_.map) reference_exposure_ = tracks.previous_exposure;
  motion.previous_exposure = reference_exposure_;
  dt_s_ = std::max(kMinDtS, to_seconds(tracks.exposure - reference_exposure_));
  wheels_ = wheels_prior_.motion_to(tracks, dt_s_);
  if (config_.map) map_.align(tracks.tracks, to_seconds(tracks.exposure - map_exposure_));
  map_exposure_ = tracks.exposure;
}

void EgomotionEstimator::gather(const TrackSet& tracks) {
  correspondences_.clear();
  const Eigen::Isometry3d T_previous_first = pose_.T_first_current().inverse();
  for (std::size_t k = 0; k < tracks.tracks.size(); ++k) {
    const Track& track = tracks.tracks[k];
    Correspondence c;
    if (!track.has_current || !usable(track.current)) continue;
    if (!find_past(tracks.camera, track, k, T_previous_first, c)) continue;
    c.track = k;
    c.observed_px = at_middle_row(tracks.camera, uvd(track.current), rows_);
    c.covariance_observed_px2 = noise_scale_ * covariance(track.current);
    correspondences_.push_back(c);
  }
}

// Hardly a track that the map knows, but enough that it does not: it learns nothing while estimates
// fail, so that waiting would not help.
bool EgomotionEstimator::is_cut_off(const TrackSet& tracks) const {
  const auto least = std::max(static_cast<std::size_t>(config_.min_inliers), kMinCorrespondences);
  if (!config_.map || correspondences_.size() >= least) return false;
  return unknown_tracks(tracks) >= kTracksToStartAnew;
}

std::size_t EgomotionEstimator::unknown_tracks(const TrackSet& tracks) const {
  std::size_t unknown = 0;
  for (std::size_t k = 0; k < tracks.tracks.size(); ++k) {
    const Track& track = tracks.tracks[k];
    unknown += track.has_current && usable(track.current) && map_.points()[k].updates == 0 ? 1 : 0;
  }
  return unknown;
}

bool EgomotionEstimator::find_past(const StereoCamera& camera, const Track& track,
                                   std::size_t index, const Eigen::Isometry3d& T_previous_first,
                                   Correspondence& c) const {
  if (!config_.map)
    return track.has_previous && usable(track.previous) &&
           correspondence_of(camera, uvd(track.previous), noise_scale_ * covariance(track.previous),
                             c);
  const MapPoint& point = map_.points()[index];
  const Eigen::Matrix3d R = T_previous_first.linear();
  c.P_previous_m = T_previous_first * point.P_first_m;
  c.covariance_previous_m2 = R * point.covariance_m2 * R.transpose();
  c.static_weight = point.static_weight;
  return point.updates > 0 && c.P_previous_m.z() > kMinDepthM;
}

Solution EgomotionEstimator::solve(const TrackSet& tracks) {
  const auto min_inliers = static_cast<std::size_t>(config_.min_inliers);
  if (correspondences_.size() < std::max(min_inliers, kMinCorrespondences))
    return {.failure = EstimateReason::kFewTracks};
  if (config_.method == EgomotionMethod::kGaussNewton)
    return gauss_newton_.solve(tracks.camera, correspondences_, motion_of(velocity_.y, dt_s_),
                               tracks.sequence);
  return sigma_point_.solve(tracks.camera, correspondences_, velocity_, dt_s_, tracks.sequence,
                            min_inliers);
}

// Empty from pair to pair.
std::span<const MapPoint> EgomotionEstimator::known_points() const {
  return config_.map ? map_.points() : std::span<const MapPoint>{};
}

bool EgomotionEstimator::rests() const {
  return velocity_.y.head<3>().norm() < kRestMps && velocity_.y.tail<3>().norm() < kRestRadps;
}

bool EgomotionEstimator::learns_readout() const {
  const bool tells = readout_.readout_s() > 0.0 || !rests();
  return config_.map && config_.method == EgomotionMethod::kGaussNewton && tells &&
         !readout_.is_none();
}

// Where the rows' times displace points by the velocity that is only being found.
void EgomotionEstimator::account_for_rows(const TrackSet& tracks, Solution& solution) {
  if (rows_.readout_s == 0.0) return;
  for (int k = 0; k < kMostSolutionsForRows && solution.failure == EstimateReason::kNone; ++k) {
    const Vector6d before = rows_.velocity;
    rows_.velocity = pair_velocity_.after(velocity_of(solution.T_previous_current, dt_s_));
    if ((rows_.velocity - before).cwiseAbs().maxCoeff() < kSameVelocity) return;
    gather(tracks);
    solution =
        gauss_newton_.solve_near(tracks.camera, correspondences_, solution.T_previous_current);
  }
}

void EgomotionEstimator::learn_readout(const TrackSet& tracks, const Solution& solution,
                                       bool is_told) {
  if (is_first_motion_)
    map_.note_first_velocity(tracks.camera,
                             pose_.T_first_current() * solution.T_previous_current.inverse(),
                             velocity_.y);
  readout_.learn(tracks.camera, correspondences_, distances2_, map_.points(),
                 solution.T_previous_current, pose_.T_first_current(), rows_.velocity, dt_s_,
                 is_told);
  const Vector6d& per_s =
      error_of_readout_.add(readout_.motion_error_per_s(), solution.T_previous_current, dt_s_);
  if (readout_.readout_s() > 0.0)
    pose_.doubt(readout_.variance_s2() * dt_s_ * per_s * per_s.transpose());
}

bool EgomotionEstimator::is_inlier(const Eigen::Isometry3d& T_current_previous, std::size_t k,
                                   const StereoCamera& camera) const {
  if (config_.method == EgomotionMethod::kGaussNewton) return distances2_[k] < config_.inlier_chi2;
  return sigma_point_.agrees(camera, T_current_previous, correspondences_[k]);
}

void EgomotionEstimator::assign_roles(const TrackSet& tracks, const Solution& solution,
                                      Egomotion& motion) {
  if (solution.failure == EstimateReason::kFewTracks) return;
  const Eigen::Isometry3d T = solution.T_previous_current.inverse();
  if (config_.method == EgomotionMethod::kGaussNewton)
    gauss_newton_.measure_distances2(T, distances2_);
  scratch_.clear();
  motion.inliers = 0;
  for (std::size_t k = 0; k < correspondences_.size(); ++k) {
    const Correspondence& c = correspondences_[k];
    if (!tracks.tracks[c.track].has_previous) continue;
    const bool inlier = is_inlier(T, k, tracks.camera);
    motion.roles[c.track] = inlier ? TrackRole::kInlier : TrackRole::kOutlier;
    if (!inlier) continue;
    ++motion.inliers;
    scratch_.push_back(
        (c.observed_px - project(tracks.camera, T * c.P_previous_m)).head<2>().squaredNorm());
  }
  motion.residual_px = std::sqrt(median(scratch_, 0.0) / kMedianChi2Of2);
}

// Among others that it does not explain, a motion explains some by chance.
int EgomotionEstimator::least_inliers(int outliers) const {
  return config_.min_inliers + std::min(outliers, config_.min_inliers) / 2;
}

EstimateReason EgomotionEstimator::judge(const Solution& solution, const Egomotion& motion) const {
  if (solution.failure == EstimateReason::kFewTracks) return solution.failure;
  const double share = motion.inliers / static_cast<double>(correspondences_.size());
  const Matrix6d& C = solution.covariance;
  // What is taken for the world may be little of the image while a mover owns the rest.
  const double least_share =
      (rival_finder_.is_in_doubt() ? kShareInDoubt : 1.0) * config_.min_inlier_share;
  const auto outliers =
      static_cast<int>(std::count(motion.roles.begin(), motion.roles.end(), TrackRole::kOutlier));
  if (motion.inliers < least_inliers(outliers) || share < least_share)
    return EstimateReason::kFewInliers;
  if (solution.failure != EstimateReason::kNone) return solution.failure;
  const bool determined =
      C.allFinite() && solution.T_previous_current.matrix().allFinite() &&
      largest_sigma(C.topLeftCorner<3, 3>()) <= config_.max_translation_sigma_m &&
      largest_sigma(C.bottomRightCorner<3, 3>()) <= config_.max_rotation_sigma_rad &&
      !inliers_lie_on_a_line(correspondences_, motion.roles);
  return determined ? EstimateReason::kNone : EstimateReason::kDegenerate;
}

// True when another motion is about as well supported: the one that the past favours is in
// `solution` then, the other one in `other`.
bool EgomotionEstimator::weigh_rival(const TrackSet& tracks, Solution& solution, Solution& other,
                                     Egomotion& motion) {
  if (tracks.previous_exposure != reference_exposure_)
    return rival_finder_.goes_on(solution, dt_s_, other);
  Rival& rival = rival_;
  const VelocityPrior prior{habit_, dt_s_, wheels_ ? &*wheels_ : nullptr};
  if (!rival_finder_.find(tracks, solution, motion.roles, known_points(), noise_scale_, prior,
                          rival))
    return false;
  other = rival.solution;
  if (!rival.preferred) return true;
  std::swap(solution, other);
  assign_roles(tracks, solution, motion);
  if (!rival.against_map) return true;
  // What the pose may be off by because of the pairs until now stays in its covariance.
  to_other_pose_.setZero();
  if (config_.map) map_.begin_again(rival.shares);
  return true;
}

// Either all that is seen moves, or the wheels have lost their grip: most of what is seen may have
// been known for long to stand still.
bool EgomotionEstimator::wheels_contradict(const Solution& solution,
                                           const Egomotion& motion) const {
  return wheels_ && wheels_->surprise(solution) > kContradiction && !is_surely_static(motion);
}

bool EgomotionEstimator::is_surely_static(const Egomotion& motion) const {
  double used = 0.0;
  double known = 0.0;
  for (std::size_t k = 0; k < motion.roles.size(); ++k) {
    if (motion.roles[k] == TrackRole::kUnused) continue;
    used += 1.0;
    if (motion.roles[k] == TrackRole::kInlier)
      known += config_.map ? known_static(map_.points()[k]) : 1.0;
  }
  return known > (config_.map ? kKnownShare : kExplainedShare) * used;
}

// If the other motion is the rig's, so it was all the time: the poses drift apart by the sum.
void EgomotionEstimator::doubt(const Solution& other, EstimateReason reason, Egomotion& motion) {
  motion.status = EstimateStatus::kAmbiguous;
  motion.reason = reason;
  motion.quality = std::min(motion.quality, kMaxAmbiguousQuality);
  const Vector6d to_other = se3_log(motion.T_previous_current.inverse() * other.T_previous_current);
  motion.covariance_previous_current += to_other * to_other.transpose() + other.covariance;
  const Vector6d before = adjoint(motion.T_previous_current.inverse()) * to_other_pose_;
  to_other_pose_ = before + to_other;
  pose_.doubt(to_other_pose_ * to_other_pose_.transpose() - before * before.transpose() +
              other.covariance);
}

void EgomotionEstimator::accept(const TrackSet& tracks, const Solution& solution, bool has_rival,
                                bool contradicted, Egomotion& motion) {
  motion.status = EstimateStatus::kValid;
  contradicted_pairs_ = 0;
  ++explained_pairs_;
  motion.reason = after_hole_ ? EstimateReason::kHole : EstimateReason::kNone;
  after_hole_ = false;
  const Matrix6d growth =
      scale_doubt_.note(tracks, correspondences_, solution.T_previous_current, dt_s_, scratch_);
  const double share = motion.inliers / static_cast<double>(correspondences_.size()) /
                       (1.0 + std::pow(scale_doubt_.sigma() / kScaleOfHalfQuality, 2));
  motion.quality = std::clamp(
      static_cast<int>(
          std::lround(100 * share * std::min(1.0, motion.inliers / kInliersOfFullQuality))),
      1, 100);
  motion.T_previous_current = solution.T_previous_current;
  const Matrix6d Ad = adjoint(solution.T_previous_current.inverse());
  motion.covariance_previous_current =
      solution.covariance + Ad * against_map_ * Ad.transpose() + scale_doubt_.covariance();
  pose_.compose(solution.T_previous_current,
                error_growth_.share(known_points(), dt_s_) * solution.covariance);
  pose_.doubt(growth);
  if (config_.map) against_map_ = solution.covariance;
  keep_velocity(motion);
  adapt_noise_scale();
  rows_.velocity = pair_velocity_.after(velocity_.y);
  motion.rows = rows_;
  const bool learns = learns_readout();
  if (learns) learn_readout(tracks, solution, !rests() && !has_rival && !contradicted);
  pair_velocity_.keep(velocity_.y);
  is_first_motion_ = false;
  if (config_.map)
    map_.update(tracks.camera, tracks.tracks, pose_.T_first_current(), solution.covariance,
                noise_scale_, contradicted, !has_rival && !contradicted,
                to_seconds(tracks.exposure - start_exposure_) < kHeldS, rows_,
                learns ? &readout_.motion_error_per_s() : nullptr);
  if (learns) map_.change_readout(readout_.change_s());
  reference_exposure_ = tracks.exposure;
  wheels_prior_.keep(tracks, solution, dt_s_);
}

void EgomotionEstimator::keep_velocity(const Egomotion& motion) {
  velocity_.y = velocity_of(motion.T_previous_current, dt_s_);
  const Matrix6d J_inverse = motion_perturbation_of_velocity(velocity_.y, dt_s_).inverse();
  velocity_.covariance = J_inverse * motion.covariance_previous_current * J_inverse.transpose();
  // A mover that starts from rest drags the velocity along until it is seen to be one.
  const double rate = has_velocity_ ? 1.0 - std::exp(-dt_s_ / kHabitS) : 1.0;
  habit_.y += rate * (velocity_.y - habit_.y);
  habit_.covariance = velocity_.covariance;
  has_velocity_ = true;
}

void EgomotionEstimator::fail(EstimateReason reason, const TrackSet& tracks, Egomotion& motion) {
  motion.status = EstimateStatus::kFailed;
  motion.reason = reason;
  pair_velocity_.clear();
  motion.covariance_previous_current = unknown_motion();
  is_lost_ = is_lost_ || tracks.discontinuity;
  const bool contradicted =
      reason == EstimateReason::kFewInliers || reason == EstimateReason::kNotConverged;
  contradicted_pairs_ = contradicted ? contradicted_pairs_ + 1 : 0;
  const int most = std::clamp(explained_pairs_ / kPairsThatEarnOne, 1, kMostContradictedPairs);
  is_lost_ = is_lost_ || (config_.map && contradicted_pairs_ >= most);
  // Frame to frame the motion of this pair is lost; tracks in the map remember where they stood.
  if (!config_.map) pose_.doubt(motion.covariance_previous_current);
}

// From the distances under the accepted motion.
void EgomotionEstimator::adapt_noise_scale() {
  if (config_.method != EgomotionMethod::kGaussNewton) return;
  scratch_.clear();
  for (std::size_t k = 0; k < correspondences_.size(); ++k)
    if (correspondences_[k].static_weight > kTrusted) scratch_.push_back(distances2_[k]);
  if (scratch_.size() < kTracksThatTellNoise) return;
  const double ratio = std::max(kMinNoiseRatio, median(scratch_, kMedianChi2Of3)) / kMedianChi2Of3;
  noise_scale_ =
      std::clamp(noise_scale_ * std::pow(ratio, kNoiseScaleRate), kMinNoiseScale, kMaxNoiseScale);
}

void EgomotionEstimator::note_common_error() {
  if (config_.method != EgomotionMethod::kGaussNewton) return;
  if (const auto common = gauss_newton_.common_error()) error_growth_.note(*common, dt_s_);
}

Matrix6d EgomotionEstimator::unknown_motion() const {
  return diagonal_covariance(config_.reset_translation_sigma_m, config_.reset_rotation_sigma_rad);
}

VelocityState EgomotionEstimator::unknown_velocity() const {
  VelocityState state;
  state.covariance = diagonal_covariance(config_.sigma_point_filter.initial_speed_sigma_mps,
                                         config_.sigma_point_filter.initial_turn_sigma_radps);
  return state;
}

// Pairs that were dropped or rejected leave a gap in the numbers, those that never came do not.
void EgomotionEstimator::watch_for_holes(const TrackSet& tracks) {
  const bool late = interval_watch_.is_late(tracks.exposure);
  const bool tracked = tracks.status != TrackStatus::kNotRun;
  const bool numbers_jump =
      tracked && started_ && tracks.sequence > last_tracked_sequence_ + skipped_ + 1;
  after_hole_ = after_hole_ || late || numbers_jump || (tracked && tracks.discontinuity);
}

}  // namespace egomod
