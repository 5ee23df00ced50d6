// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/feature_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "bridging.hpp"
#include "egomod/core/pair_rate.hpp"
#include "mover_search.hpp"
#include "observation.hpp"
#include "rig_motion.hpp"
#include "right_turn.hpp"
#include "seeding.hpp"
#include "skew.hpp"
#include "stereo_alignment.hpp"
#include "stereo_images.hpp"
#include "temporal_alignment.hpp"
#include "track_store.hpp"

namespace egomod {
namespace {

constexpr int kMinImageSide_px = 48;
constexpr std::size_t kFewTracks = 20;
constexpr int kMaxPairsAlone = 20;
constexpr int kPairsToKnowMotion = 8;
// Shares of points not found that call for the wide search, and that discredit the prediction.
constexpr float kBridgingShare = 0.3F;
constexpr float kSurpriseShare = 0.5F;
// Beyond 1000 the drift does not fall; see docs/egomotion.md for what each costs.
constexpr int kMaxTracks = 1000;
constexpr int kMaxTracksBaseline = 550;
constexpr float kMaxNccDrop = 0.06F;    // below the track's own level
constexpr float kMaxDeviation = 0.45F;  // of the warp from the identity
constexpr float kFirstNccLevel = 0.9F;
constexpr float kRenewedNccLevel = 0.85F;
constexpr std::size_t kMostRows = 150;  // that tell a turn of the right camera, a pair
constexpr float kNccMemory = 0.98F;
// Few, in buckets that are small for it: else a wall's bricks leave none to plain things before it.
constexpr int kCornersPerBucket = 3;

bool usable(const StereoPair& pair) {
  return pair.status == PairStatus::kOk && pair.left.width_px() >= kMinImageSide_px &&
         pair.left.height_px() >= kMinImageSide_px &&
         pair.left.width_px() == pair.right.width_px() &&
         pair.left.height_px() == pair.right.height_px();
}

FeaturesConfig with_track_count(FeaturesConfig config) {
  config.max_tracks = max_tracks(config);
  return config;
}

CornerConfig corner_config(const FeaturesConfig& config, int width_px, int height_px) {
  CornerConfig corners;
  corners.corners_per_bucket = kCornersPerBucket;
  // Not every bucket has texture: room for a third more than can be had.
  const double places = 1.33 * config.max_tracks;
  const double area = static_cast<double>(width_px) * height_px * corners.corners_per_bucket;
  corners.bucket_px = std::max(16, static_cast<int>(std::lround(std::sqrt(area / places))));
  corners.border_px = kTemplateMargin_px + 3;
  return corners;
}

DisparityConfig disparity_config(const FeaturesConfig& config, int width_px) {
  DisparityConfig disparity;
  disparity.max_disparity_px = static_cast<int>(std::lround(config.max_disparity_share * width_px));
  return disparity;
}

float deviation(const AffineWarp& w) {
  return std::sqrt((w.a - 1) * (w.a - 1) + w.b * w.b + w.c * w.c + (w.d - 1) * (w.d - 1));
}

// Whether a new calibration moves the rectified images against those before.
bool moves_images(const Calibration& before, const Calibration& now) {
  return now.images_are_raw &&
         (before.camera != now.camera || before.left != now.left || before.right != now.right);
}

// The right camera does not see what is at the left border; what moves there is worth following
// all the same, since its motion is known by then.
bool goes_on_alone(const FollowedPoint& p) {
  return !p.stereo.valid && p.pairs_without_stereo <= kMaxPairsAlone &&
         p.pairs_moving - p.pairs_without_stereo >= kPairsToKnowMotion;
}

bool has_lost_sight(const FollowedPoint& p) {
  const bool lost_stereo = p.pairs_without_stereo > kMaxPairsWithoutStereo && !goes_on_alone(p);
  return !p.followed || p.refuted || lost_stereo;
}

// What depends on the image size.
struct Workers {
  Workers(const FeaturesConfig& config, int width, int height)
      : width_px(width),
        height_px(height),
        temporal(config.max_tracks),
        stereo(config.max_tracks, disparity_config(config, width)),
        bridging(config.max_tracks, corner_config(config, width, height),
                 config.search_radius_share),
        movers(config.max_tracks),
        seeding(config.max_tracks, corner_config(config, width, height),
                disparity_config(config, width)) {}

  int width_px;
  int height_px;
  TemporalAlignment temporal;
  StereoAlignment stereo;
  Bridging bridging;
  MoverSearch movers;
  Seeding seeding;
};

}  // namespace

int usual_max_tracks(InstructionSet set) {
  return set == InstructionSet::kBaseline ? kMaxTracksBaseline : kMaxTracks;
}

int max_tracks(const FeaturesConfig& config) {
  return config.max_tracks > 0 ? config.max_tracks : usual_max_tracks(instruction_set());
}

class FeatureTracker::Implementation {
 public:
  explicit Implementation(const FeaturesConfig& config)
      : config_(with_track_count(config)), store_(config_.max_tracks) {}

  void track(const StereoPair& pair, TrackSet& tracks);

 private:
  void begin_pair(const StereoPair& pair);
  [[nodiscard]] float next_interval_ratio(Nanoseconds exposure);
  void follow();
  void follow_others();
  void bridge();
  [[nodiscard]] float lost_share() const;
  void renew_anchors();
  void publish(TrackSet& tracks);
  [[nodiscard]] TrackStatus status(const TrackSet& tracks, std::size_t survivors) const;

  [[nodiscard]] StereoImages& current() { return images_[newest_]; }
  [[nodiscard]] StereoImages& previous() { return images_[1 - newest_]; }

  FeaturesConfig config_;
  TrackStore store_;
  RigMotion rig_motion_;
  Skew skew_;
  RightTurn right_turn_{kMostRows};
  std::optional<Workers> workers_;
  std::array<StereoImages, 2> images_;
  std::size_t newest_ = 0;
  Calibration calibration_;
  bool first_ = true;
  bool restarted_ = false;
  bool recalibrated_ = false;  // another turn of the right camera is taken out
  Nanoseconds last_exposure_{0};
  double last_interval_s_ = 0.0;
  bool is_slow_ = false;  // pairs are far apart
};

void FeatureTracker::Implementation::track(const StereoPair& pair, TrackSet& tracks) {
  tracks.sequence = pair.sequence;
  tracks.exposure = pair.exposure;
  tracks.previous_exposure = first_ ? pair.exposure : last_exposure_;
  tracks.pair_status = pair.status;
  tracks.discontinuity = pair.discontinuity;
  tracks.camera = pair.calibration.camera;
  tracks.wheels = pair.wheels;
  tracks.T_body_camera = pair.calibration.T_body_camera;
  tracks.max_tracks = config_.max_tracks;
  tracks.right_turn = {right_turn_.is_off(), right_turn_.turn_rad(), right_turn_.yaw_sigma_rad(),
                       false};
  tracks.tracks.clear();
  tracks.status = TrackStatus::kNotRun;
  if (!usable(pair)) return;

  begin_pair(pair);
  tracks.right_turn = {right_turn_.is_off(), right_turn_.turn_rad(), right_turn_.yaw_sigma_rad(),
                       recalibrated_};
  follow();
  skew_.move(rig_motion_.T_current_previous());
  workers_->stereo.measure(previous(), current(), skew_, store_);
  store_.drop_if(has_lost_sight);
  renew_anchors();
  const std::size_t survivors = store_.points().size();
  workers_->seeding.seed(current(), skew_, store_);
  if (skew_.is_synchronised())
    right_turn_.measure(pair.calibration.camera, current(), store_, last_interval_s_);
  publish(tracks);
  tracks.discontinuity = !first_ && restarted_;
  tracks.status = status(tracks, survivors);
  last_exposure_ = pair.exposure;
  first_ = false;
}

// Of the time since the last pair and the interval before it: motion a pair grows with it.
float FeatureTracker::Implementation::next_interval_ratio(Nanoseconds exposure) {
  const double interval_s = to_seconds(exposure - last_exposure_);
  const double ratio =
      interval_s > 0.0 && last_interval_s_ > 0.0 ? interval_s / last_interval_s_ : 1.0;
  is_slow_ = is_low_rate(interval_s, last_interval_s_);
  last_interval_s_ = first_ ? 0.0 : interval_s;
  return static_cast<float>(std::clamp(ratio, 0.1, 10.0));
}

// A cut, a new image size or another rectification ends all tracks.
void FeatureTracker::Implementation::begin_pair(const StereoPair& pair) {
  const int width_px = pair.left.width_px();
  const int height_px = pair.left.height_px();
  const bool resized =
      !workers_ || workers_->width_px != width_px || workers_->height_px != height_px;
  if (resized) workers_.emplace(config_, width_px, height_px);
  const bool moved = !first_ && moves_images(calibration_, pair.calibration);
  const bool calibration_changed = first_ || !(calibration_ == pair.calibration);
  calibration_ = pair.calibration;
  if (calibration_changed) right_turn_.forget();
  recalibrated_ = right_turn_.take_change();
  restarted_ = pair.discontinuity || resized || moved || recalibrated_;
  skew_.turn_right_camera(right_turn_.turn_rad());
  if (restarted_) store_.clear();
  newest_ = 1 - newest_;
  current().take(pair);
  const float interval_ratio = next_interval_ratio(pair.exposure);
  rig_motion_.begin_pair(pair.calibration.camera, !restarted_, interval_ratio);
  skew_.begin_pair(pair.calibration.camera, pair.skew(), pair.exposure - last_exposure_,
                   !restarted_);
  for (FollowedPoint& point : store_.points()) {
    ++point.age;
    point.flow.u_px *= interval_ratio;
    point.flow.v_px *= interval_ratio;
    point.disparity_rate_px *= interval_ratio;
    point.previous_warp = point.warp;
    point.previous_left = point.left;
    point.previous_stereo = point.stereo;
    point.previous_observation = point.observation;
    point.has_previous_observation = point.stereo.valid;
    point.stereo.valid = false;
    point.followed = false;
    point.reanchored = false;
  }
}

void FeatureTracker::Implementation::follow() {
  TemporalAlignment& temporal = workers_->temporal;
  using Part = TemporalAlignment::Part;
  temporal.follow_expected(Part::kScouts, rig_motion_, previous(), current(), store_);
  rig_motion_.guess(store_);
  temporal.follow_expected(Part::kOthers, rig_motion_, previous(), current(), store_);
  if (lost_share() < kSurpriseShare) follow_others();
  const bool bridging = lost_share() > kBridgingShare;
  if (bridging) bridge();
  temporal.give_up_young_loners(rig_motion_, store_);
  if (!bridging)
    workers_->movers.find_lost(previous(), current(), rig_motion_, is_slow_, temporal, store_);
  TemporalAlignment::remember_resting(rig_motion_, store_);
}

void FeatureTracker::Implementation::follow_others() {
  rig_motion_.guess(store_);
  workers_->temporal.follow_rig(rig_motion_, current(), store_);
  workers_->temporal.follow_neighbours(rig_motion_, previous(), current(), store_);
}

// Where most points are not found as predicted, the few that are may be look-alikes: all start over
// from the wide search, and only flows that neighbours share count.
void FeatureTracker::Implementation::bridge() {
  TemporalAlignment& temporal = workers_->temporal;
  if (lost_share() > kSurpriseShare) {
    for (FollowedPoint& point : store_.points()) point.followed = false;
  }
  workers_->bridging.find_lost(previous(), current(), temporal, store_);
  temporal.give_up_loners(store_);
  follow_others();
  temporal.give_up_loners(store_);
}

float FeatureTracker::Implementation::lost_share() const {
  const std::vector<FollowedPoint>& points = store_.points();
  const auto lost = std::count_if(points.begin(), points.end(),
                                  [](const FollowedPoint& p) { return !p.followed; });
  return points.empty() ? 0.0F : static_cast<float>(lost) / static_cast<float>(points.size());
}

// A template is renewed when it no longer fits as well as it used to, or when the view has changed
// beyond what sampling bears; each renewal starts the random walk of a new anchor.
void FeatureTracker::Implementation::renew_anchors() {
  const ImageView left = current().left.level(0);
  for (FollowedPoint& point : store_.points()) {
    point.usual_ncc = std::max(kNccMemory * point.usual_ncc, point.ncc);
    const bool worn =
        point.ncc < point.usual_ncc - kMaxNccDrop || deviation(point.warp) > kMaxDeviation;
    if (!worn || !point.stereo.valid || !holds_template(left, nearest_pixel(point.left))) continue;
    store_.anchor_here(left, point);
    point.usual_ncc = kRenewedNccLevel;
    point.reanchored = true;
  }
}

void FeatureTracker::Implementation::publish(TrackSet& tracks) {
  for (FollowedPoint& point : store_.points()) {
    if (point.age == 0) point.usual_ncc = kFirstNccLevel;
    const AffineTemplate& anchor = store_.anchor(point);
    point.observation = observe(point, anchor);
    tracks.tracks.push_back({.id = point.id,
                             .age = point.age,
                             .has_current = point.stereo.valid,
                             .has_previous = point.has_previous_observation,
                             .left_only = goes_on_alone(point),
                             .reanchored = point.reanchored,
                             .ncc = point.ncc,
                             .ncc_right = point.stereo.ncc,
                             .min_eigenvalue = texture(point, anchor),
                             .current = point.observation,
                             .previous = point.previous_observation});
  }
}

TrackStatus FeatureTracker::Implementation::status(const TrackSet& tracks,
                                                   std::size_t survivors) const {
  if (tracks.tracks.size() < kFewTracks) return TrackStatus::kFew;
  if (first_) return TrackStatus::kFirst;
  return restarted_ || survivors == 0 ? TrackStatus::kReseeded : TrackStatus::kOk;
}

FeatureTracker::FeatureTracker(const FeaturesConfig& config)
    : implementation_(std::make_unique<Implementation>(config)) {}
FeatureTracker::~FeatureTracker() = default;

void FeatureTracker::track(const StereoPair& pair, TrackSet& tracks) {
  implementation_->track(pair, tracks);
}

}  // namespace egomod
