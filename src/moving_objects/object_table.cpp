// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/object_table.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/moving_objects/evidence_gates.hpp"
#include "moving_objects/body_motion.hpp"
#include "moving_objects/group_shape.hpp"
#include "moving_objects/recent_motion.hpp"

namespace egomod {
namespace {

constexpr std::size_t kClearPoints = 8;  // that agree over one long interval
constexpr double kTentative_s = 0.3;     // a tentative object without evidence ends
constexpr double kLeaveChi2 = 25.0;      // a member this far off leaves
constexpr double kManoeuvre_s = 1.0;     // how long an unseen one lasts
constexpr double kPartGapShare = 0.4;    // of the larger one's size, across the line of sight
constexpr double kPartDepthShare = 1.0;
constexpr double kPastDepth_m = 0.5;
constexpr std::ptrdiff_t kLeastPast = 3;
constexpr double kLimbSpan_m = 0.4;  // beside the trunk
constexpr double kLimbDepth_m = 0.5;
// Of a person, whose legs are found without the trunk's velocity.
constexpr double kWidestTrunk_m = 1.0;
constexpr double kLegSpan_m = 0.25;   // beside the trunk
constexpr double kTallest_m = 1.9;    // with its legs
constexpr double kStraySpan_m = 0.7;  // nothing of a person is alone so far beside the rest
constexpr double kOutline_s = 0.15;   // its rectangle shrinks in
constexpr double kHeadHeight_m = 0.35;
constexpr double kDeepestTrunk_m = 0.5;
// Error of a surface's centre by its size, however many points show it.
constexpr double kShapeShare = 0.04;
constexpr double kYoungVariance = 2.0;  // of a velocity just found, above that of a known one
constexpr std::size_t kLeastPoints = MotionGroups::kLeastPoints;

// Few points show the outline of a surface badly, and many not exactly.
double shape_variance_m2(const MovingObject& object) {
  const double share = kShapeShare + 1.0 / std::max(1, object.points);
  const double size_m = object.extent_m.head<2>().maxCoeff();
  return share * share * size_m * size_m;
}

bool is_finite(const MovingObject& object) {
  return object.position_m.allFinite() && object.velocity_mps.allFinite() &&
         object.position_covariance_m2.allFinite() &&
         object.velocity_covariance_m2ps2.allFinite() && std::isfinite(object.motion_probability);
}

bool rests(const PointSample& point) { return point.stands && !point.left_only; }

// Of velocities, as a variance.
Eigen::Matrix3d scatter_about(std::span<const PointSample> points, Members members,
                              const Eigen::Vector3d& velocity_mps) {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const auto i : members) {
    const Eigen::Vector3d off_mps = points[i].velocity_mps - velocity_mps;
    squares += off_mps * off_mps.transpose();
  }
  return squares / static_cast<double>(members.size());
}

MotionStart start_of(std::span<const PointSample> points, Members members) {
  MotionStart start;
  const auto count = static_cast<double>(members.size());
  for (const auto i : members) {
    start.stood_share += (points[i].stood ? 1.0 : 0.0) / count;
    start.learnt_s += points[i].learnt_s / count;
  }
  return start;
}

}  // namespace

ObjectTable::ObjectTable(const MovingObjectsConfig& config, const ObjectGates& gates)
    : config_(config), gates_(gates) {
  objects_.reserve(kMostObjects);
  for (auto* ids : {&track_ids_, &previous_track_ids_}) ids->reserve(kReservedTracks);
  for (auto* owners : {&owners_, &previous_owners_}) owners->reserve(kReservedTracks);
  for (auto* members : {&members_, &seen_, &trunk_, &outline_}) members->reserve(kReservedTracks);
}

bool ObjectTable::are_near(const Box& a, const Box& b, double sigma_m) const {
  Eigen::Vector3d gap = space_between(a, b);
  gap.y() /= MotionGroups::kUprightReach;
  const double size_m = std::max(a.size_m.maxCoeff(), b.size_m.maxCoeff());
  const double width_m = std::max(a.size_m.x(), b.size_m.x());
  return gap.head<2>().norm() < std::max(config_.neighbour_distance_m, kPartGapShare * width_m) &&
         gap.z() < std::max(config_.neighbour_depth_m, kPartDepthShare * size_m) + 2.5 * sigma_m;
}

// What rests behind both shows between them: they are two.
bool ObjectTable::are_seen_past(std::span<const PointSample> points, const Shape& a,
                                const Shape& b) {
  const PixelRect gap = gap_between(a.rectangle, b.rectangle);
  const auto far_side_m = [](const Box& box) { return box.centre_m.z() + 0.5 * box.size_m.z(); };
  const double behind_m = std::max(far_side_m(a.box), far_side_m(b.box)) + kPastDepth_m;
  const auto shows = std::count_if(points.begin(), points.end(), [&](const PointSample& point) {
    return point.stands && point.position_m.z() > behind_m && contains(gap, point.pixel_px);
  });
  return shows >= kLeastPast;
}

ObjectTable::Box ObjectTable::joined(const Box& a, const Box& b) {
  const Eigen::Vector3d low_m = (a.centre_m - 0.5 * a.size_m).cwiseMin(b.centre_m - 0.5 * b.size_m);
  const Eigen::Vector3d high_m =
      (a.centre_m + 0.5 * a.size_m).cwiseMax(b.centre_m + 0.5 * b.size_m);
  return {0.5 * (low_m + high_m), high_m - low_m};
}

bool ObjectTable::is_at(const PointSample& point, const Box& box) {
  const Eigen::Vector3d off_m = (point.position_m - box.centre_m).cwiseAbs() - 0.5 * box.size_m;
  return off_m.x() < kLimbSpan_m && off_m.z() < kLimbDepth_m;
}

// Of a person; none in what is larger.
std::optional<ObjectTable::Box> ObjectTable::trunk_in(Box box) {
  if (box.size_m.x() > kWidestTrunk_m || box.size_m.y() > kTallest_m) return std::nullopt;
  box.size_m.z() = std::min(box.size_m.z(), kDeepestTrunk_m);
  return box;
}

// Below it its legs, above it its head: all of it no taller than a person.
bool ObjectTable::hangs_on(const Eigen::Vector3d& position_m, const Box& trunk,
                           double beside_reach_m) {
  const Eigen::Vector3d off_m = position_m - trunk.centre_m;
  const Eigen::Vector3d beside_m = off_m.cwiseAbs() - 0.5 * trunk.size_m;
  return beside_m.x() < beside_reach_m && beside_m.z() < kLimbDepth_m &&
         -off_m.y() - 0.5 * trunk.size_m.y() < kHeadHeight_m &&
         off_m.y() + 0.5 * trunk.size_m.y() < kTallest_m;
}

void ObjectTable::move_on(const StereoCamera& camera, Nanoseconds exposure,
                          const Eigen::Isometry3d& T_current_previous) {
  const double elapsed_s = to_seconds(exposure - now_);
  now_ = exposure;
  is_slow_ = false;
  lost_.move_on(exposure, T_current_previous);
  const Eigen::Matrix3d R = T_current_previous.linear();
  for (Tracked& tracked : objects_) {
    MovingObject& object = tracked.object;
    const Eigen::Vector3d before_m = object.position_m;
    object.position_m = T_current_previous * (before_m + elapsed_s * object.velocity_mps);
    tracked.box.centre_m =
        T_current_previous * (tracked.box.centre_m + elapsed_s * object.velocity_mps);
    object.velocity_mps = R * object.velocity_mps;
    object.angular_velocity_radps = R * object.angular_velocity_radps;
    tracked.manoeuvre.rotate(R);
    doubt(elapsed_s, to_seconds(now_ - tracked.last_evidence), object);
    object.position_covariance_m2 = R * object.position_covariance_m2 * R.transpose();
    object.velocity_covariance_m2ps2 = R * object.velocity_covariance_m2ps2 * R.transpose();
    set_speed(object);
    object.rectangle = carried(camera, object.rectangle, before_m, object.position_m);
    object.age_s = to_seconds(now_ - tracked.first_seen);
    object.points = 0;
    tracked.evident = false;
    tracked.by_limbs = false;
    tracked.by_few = false;
  }
}

// The longer unseen, the less is known: an error of velocity adds up, and things manoeuvre.
void ObjectTable::doubt(double elapsed_s, double unseen_s, MovingObject& object) const {
  const double before_s = std::max(0.0, unseen_s - elapsed_s);
  object.position_covariance_m2 +=
      (unseen_s * unseen_s - before_s * before_s) * object.velocity_covariance_m2ps2;
  const double a_mps2 = config_.acceleration_mps2 + config_.manoeuvre_hz * object.speed_mps;
  object.velocity_covariance_m2ps2.diagonal().array() += a_mps2 * a_mps2 * kManoeuvre_s * elapsed_s;
}

void ObjectTable::miss(const TrackSet& tracks) {
  move_on(tracks.camera, tracks.exposure, Eigen::Isometry3d::Identity());
  for (Tracked& tracked : objects_) {
    if (tracked.object.state == ObjectState::kMoving) tracked.object.state = ObjectState::kCoasting;
  }
  forget_lost();
}

void ObjectTable::forget_lost() {
  const std::size_t before = objects_.size();
  std::erase_if(objects_, [this](const Tracked& tracked) {
    const bool lost = is_lost(tracked);
    if (lost) remember(tracked);
    return lost;
  });
  if (objects_.size() == before) return;
  for (std::int64_t& owner : owners_) {
    const bool lives = std::any_of(objects_.begin(), objects_.end(), [&](const Tracked& tracked) {
      return tracked.object.id == owner;
    });
    if (!lives) owner = 0;
  }
}

void ObjectTable::remember(const Tracked& tracked) {
  lost_.give_back(tracked.object.id);
  if (!tracked.confirmed || !is_finite(tracked.object)) return;
  lost_.remember({.id = tracked.object.id,
                  .first_seen = tracked.first_seen,
                  .last_seen = tracked.last_evidence,
                  .centre_m = tracked.box.centre_m,
                  .velocity_mps = tracked.object.velocity_mps});
}

void ObjectTable::predict(const TrackSet& tracks, const Egomotion& motion) {
  if (motion.reset_count != reset_count_) lost_.clear();  // where they are now is not known
  reset_count_ = motion.reset_count;
  move_on(tracks.camera, tracks.exposure, motion.T_previous_current.inverse());
  owners_.swap(previous_owners_);
  track_ids_.swap(previous_track_ids_);
  owners_.assign(tracks.tracks.size(), 0);
  track_ids_.clear();
  std::size_t k = 0;
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    const std::uint64_t id = tracks.tracks[i].id;
    track_ids_.push_back(id);
    while (k < previous_track_ids_.size() && previous_track_ids_[k] < id) ++k;
    if (k < previous_track_ids_.size() && previous_track_ids_[k] == id) {
      owners_[i] = previous_owners_[k];
    }
  }
}

void ObjectTable::update(const StereoCamera& camera, std::span<const PointSample> points,
                         bool motion_is_valid) {
  for (Tracked& tracked : objects_) {
    collect(points, tracked);
    tracked.evident = tracked.evident && is_proper(points, tracked);
    if (!tracked.evident) {
      coast(camera, points, tracked);
      continue;
    }
    ++tracked.pairs;
    tracked.last_evidence = now_;
    measure(camera, points, tracked);
    const bool proven = is_proven(tracked);
    tracked.confirmed = tracked.confirmed || (proven && motion_is_valid);
    if (tracked.confirmed) lost_.erase(tracked.object.id);
    tracked.object.state = tracked.confirmed ? ObjectState::kMoving : ObjectState::kTentative;
  }
  absorb_parts(camera, points);
  forget_lost();
}

// A pair after a long interval tells as much as many that follow each other quickly.
bool ObjectTable::is_proven(const Tracked& tracked) const {
  if (is_slow_ && (tracked.pairs >= gates_.confirm_pairs || members_.size() >= kClearPoints))
    return true;
  return tracked.pairs >= gates_.confirm_pairs &&
         to_seconds(now_ - tracked.first) >= gates_.confirm_s &&
         tracked.evidence >= gates_.confirm_evidence;
}

bool ObjectTable::is_proper(std::span<const PointSample> points, const Tracked& tracked) const {
  if (tracked.by_few) return members_.size() >= kFewPoints;
  const std::size_t least = tracked.confirmed || tracked.swings
                                ? kLeastPoints
                                : static_cast<std::size_t>(config_.min_points);
  return members_.size() >= least &&
         is_pure(points, members_, tracked.by_limbs ? 1.0 : kKeepPurityShare);
}

bool ObjectTable::moves_with_owner(std::size_t track, const Eigen::Vector3d& velocity_mps,
                                   const Eigen::Matrix3d& covariance_m2ps2) const {
  const auto owner = std::find_if(objects_.begin(), objects_.end(), [&](const Tracked& tracked) {
    return is_known(tracked) && !tracked.swings && tracked.object.id == owners_[track];
  });
  if (owner == objects_.end()) return false;
  const Eigen::Vector3d off = velocity_mps - owner->object.velocity_mps;
  return off.dot(covariance_m2ps2.ldlt().solve(off)) < kLeaveChi2;
}

// One wrong member blows a rectangle of extremes up: whoever "static" explains better leaves.
bool ObjectTable::belongs(const PointSample& point, const Tracked& tracked) const {
  if (tracked.swings && point.moves) return is_at(point, tracked.box);
  const double against = velocity_chi2(point, tracked.object.velocity_mps);
  return against < kLeaveChi2 && (point.moves || against < point.chi2);
}

void ObjectTable::collect(std::span<const PointSample> points, const Tracked& tracked) {
  members_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int64_t& owner = owners_[points[i].track];
    if (owner != tracked.object.id) continue;
    if (!tracked.evident || belongs(points[i], tracked)) {
      members_.push_back(static_cast<Grouper::Index>(i));
    } else if (!tracked.by_few) {
      owner = 0;
    }
  }
}

// The members, and what hangs on a trunk or stands on it: legs, whose velocities are their own. A
// body that is larger than one has none, but perhaps a shadow.
Members ObjectTable::outline_of(std::span<const PointSample> points, Members seen,
                                const Tracked& tracked) {
  if (!tracked.confirmed || seen.empty()) return members_;
  const auto trunk = trunk_in({centre_of(points, seen), extent_of(points, seen)});
  if (!trunk) return members_;
  outline_.assign(members_.begin(), members_.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool moves = points[i].moves && points[i].chi2 > kMovingAloneChi2;
    if (!moves || points[i].left_only || owners_[points[i].track] != 0) continue;
    if (hangs_on(points[i].position_m, *trunk, kLegSpan_m))
      outline_.push_back(static_cast<Grouper::Index>(i));
  }
  return outline_.size() < members_.size() + kLeastPoints ? Members(members_) : Members(outline_);
}

// One wrong point beside it would stretch a rectangle over what is next to it.
Members ObjectTable::without_stray(const StereoCamera& camera, std::span<const PointSample> points,
                                   Members outline, double depth_m) {
  const std::size_t stray = stray_of(points, outline, kStraySpan_m * camera.fx_px / depth_m);
  if (stray == outline.size()) return outline;
  if (outline.data() != outline_.data()) outline_.assign(outline.begin(), outline.end());
  outline_.erase(outline_.begin() + static_cast<std::ptrdiff_t>(stray));
  return outline_;
}

void ObjectTable::measure(const StereoCamera& camera, std::span<const PointSample> points,
                          Tracked& tracked) {
  const Members seen = seen_by_both(points);
  measure_place(camera, points, seen, tracked);
  MovingObject& object = tracked.object;
  tracked.latest = {object.velocity_mps, object.velocity_covariance_m2ps2};
  if (!seen.empty()) measure_motion(points, seen, tracked);
  set_speed(object);
}

void ObjectTable::measure_place(const StereoCamera& camera, std::span<const PointSample> points,
                                Members seen, Tracked& tracked) {
  MovingObject& object = tracked.object;
  // Features sit where the texture is: the ray through the rectangle's centre at their depth is
  // nearer to the centre of the visible surface than their mean.
  const double z_m = seen.empty() ? object.position_m.z() : mean_position(points, seen).z();
  const Members outline = without_stray(camera, points, outline_of(points, seen, tracked), z_m);
  // Points come and go, most of all on somebody who walks: the outline does not as fast, and few
  // points do not tell it.
  const PixelRect now = rectangle_of(points, outline);
  const double passed_s = std::max(0.0, to_seconds(now_ - tracked.outlined));
  const double kept = tracked.by_few ? 1.0 : std::exp(-passed_s / kOutline_s);
  object.rectangle = tracked.confirmed ? shrunk(object.rectangle, now, kept) : now;
  tracked.outlined = now_;
  tracked.own_rectangle = rectangle_of(points, members_);
  object.extent_m = extent_of(points, outline);
  tracked.width_m = std::max(tracked.width_m, object.extent_m.x());
  object.points = static_cast<int>(members_.size());
  const PixelRect& r = object.rectangle;
  object.position_m = {(0.5 * (r.u_min_px + r.u_max_px) - camera.cx_px) / camera.fx_px * z_m,
                       (0.5 * (r.v_min_px + r.v_max_px) - camera.cy_px) / camera.fy_px * z_m, z_m};
  if (!seen.empty())
    object.position_covariance_m2 = mean_covariance(points, seen, config_.error_correlation,
                                                    &PointSample::position_covariance_m2) +
                                    shape_variance_m2(object) * Eigen::Matrix3d::Identity();
  object.motion_probability = logistic(joint_evidence(points, members_, config_.error_correlation));
}

// The members that tell depth and velocity; none where too few do: the last disparities before the
// border, or something nearer, hides a point from the right camera may be of that.
Members ObjectTable::seen_by_both(std::span<const PointSample> points) {
  seen_.clear();
  for (const auto i : members_)
    if (!points[i].left_only) seen_.push_back(i);
  if (seen_.size() < members_.size() && seen_.size() < kLeastPoints) seen_.clear();
  return seen_;
}

// The members that have the object's velocity: all of them, but for limbs that swing.
Members ObjectTable::trunk_of(std::span<const PointSample> points, Members members,
                              const Tracked& tracked) {
  if (!tracked.swings) return members;
  trunk_.clear();
  for (const auto i : members) {
    if (velocity_chi2(points[i], tracked.object.velocity_mps) < kLeaveChi2) trunk_.push_back(i);
  }
  return trunk_;
}

void ObjectTable::measure_motion(std::span<const PointSample> points, Members members,
                                 Tracked& tracked) {
  MovingObject& object = tracked.object;
  const Members trunk = trunk_of(points, members, tracked);
  if (trunk.empty()) {
    tracked.latest.covariance_m2ps2 += scatter_about(points, members, object.velocity_mps);
    return;
  }
  tracked.last_velocity = now_;
  const BodyMotion body =
      fit_body_motion(points, trunk, object.position_m, config_.error_correlation);
  Manoeuvre& manoeuvre = tracked.manoeuvre;
  manoeuvre.follow(body, now_, start_of(points, trunk));
  object.velocity_mps = body.velocity_mps + manoeuvre.lead_mps();
  object.angular_velocity_radps = body.angular_velocity_radps;
  Eigen::Matrix3d manoeuvres_m2ps2 = manoeuvre.covariance_m2ps2();
  // Where a turning body is not quite where it is thought to be, another part of it is.
  const Eigen::Matrix3d lever = skew(body.angular_velocity_radps);
  const double youth = 1.0 + kYoungVariance * manoeuvre.youth();
  const Eigen::Matrix3d rest_m2ps2 = youth * body.velocity_covariance_m2ps2 +
                                     lever * object.position_covariance_m2 * lever.transpose();
  object.velocity_covariance_m2ps2 = rest_m2ps2 + manoeuvres_m2ps2;
  tracked.latest.mps = object.velocity_mps + manoeuvre.steady_lead_mps();
  if (manoeuvre.has_past()) {
    const Eigen::Vector3d ray = object.position_m.normalized();
    const Eigen::Vector3d behind_mps =
        manoeuvre.behind_share() * ray.dot(object.velocity_mps) * ray;
    take(fit_recent_motion(points, trunk, body, object.position_m, tracked.latest.mps,
                           manoeuvre.acceleration_m2ps4()),
         behind_mps * behind_mps.transpose(), tracked.latest.mps, manoeuvres_m2ps2);
  }
  tracked.latest.covariance_m2ps2 = rest_m2ps2 + manoeuvres_m2ps2;
}

// Without a group of its own: does it rest, or is it only not seen?
void ObjectTable::coast(const StereoCamera& camera, std::span<const PointSample> points,
                        Tracked& tracked) {
  const auto still =
      std::count_if(members_.begin(), members_.end(), [&](auto i) { return rests(points[i]); });
  const auto count = static_cast<std::ptrdiff_t>(members_.size());
  const bool stopped = still >= static_cast<std::ptrdiff_t>(kLeastPoints) && 2 * still > count;
  MovingObject& object = tracked.object;
  object.points = stopped || !tracked.confirmed ? static_cast<int>(count) : 0;
  if (!tracked.confirmed) return;
  object.state = stopped ? ObjectState::kStopped : ObjectState::kCoasting;
  if (stopped) rest(camera, points, tracked);
  remember(tracked);
}

// It is where its points stand, and has their doubt about their velocity, but none itself.
void ObjectTable::rest(const StereoCamera& camera, std::span<const PointSample> points,
                       Tracked& tracked) {
  std::erase_if(members_, [&](auto i) { return !rests(points[i]); });
  measure_place(camera, points, members_, tracked);
  tracked.box = {centre_of(points, members_), extent_of(points, members_)};
  MovingObject& object = tracked.object;
  object.velocity_mps.setZero();
  object.angular_velocity_radps.setZero();
  object.velocity_covariance_m2ps2 = mean_covariance(points, members_, config_.error_correlation,
                                                     &PointSample::velocity_covariance_m2ps2);
  set_speed(object);
}

bool ObjectTable::is_lost(const Tracked& tracked) const {
  const double patience_s = tracked.confirmed ? config_.coast_s : kTentative_s;
  return to_seconds(now_ - tracked.last_evidence) > patience_s || !is_finite(tracked.object) ||
         !tracked.latest.mps.allFinite();
}

void ObjectTable::report(std::vector<MovingObject>& objects) const {
  for (const Tracked& tracked : objects_) {
    MovingObject& object = objects.emplace_back(tracked.object);
    if (!tracked.evident) continue;
    object.velocity_mps = tracked.latest.mps;
    object.velocity_covariance_m2ps2 = tracked.latest.covariance_m2ps2;
    set_speed(object);
  }
}

}  // namespace egomod
