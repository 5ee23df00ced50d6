// SPDX-License-Identifier: Apache-2.0
// Which object each group of moving points belongs to, and which groups open a new one.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/moving_objects/evidence_gates.hpp"
#include "moving_objects/object_table.hpp"

namespace egomod {
namespace {

constexpr double kKnown_s = 1.0;
constexpr double kLarge_m = 1.0;  // wide: no person is, nor a small robot
constexpr std::ptrdiff_t kConfirmedWeight = 2;
constexpr double kReclaimDistance_m = 0.5;  // an object without tracks is found again this near,
constexpr double kReclaimDrift_mps = 0.3;   // growing with the time that it was unseen,
constexpr double kReclaimSpeed_mps = 0.3;   // at a velocity this similar
constexpr double kReclaimSpeedShare = 0.1;
constexpr double kGoOnChi2 = 25.0;   // of a point's velocity against the object's
constexpr double kLeapPurity = 0.8;  // of what opens an object over a long interval
constexpr std::size_t kLimbRatio = 2;
constexpr double kLimbWidth_m = 0.3;
constexpr double kLimbSwing_m = 0.55;  // beside the trunk
constexpr double kLimbMemory_s = 0.3;
constexpr double kVelocityMemory_s = 0.4;  // about half a step
constexpr double kLeap_mps = 0.5;
constexpr double kLeapShare = 0.4;
constexpr double kLimbReach_m = 0.3;     // from the rectangle
constexpr float kUpright = 3.0F;         // of that, up and down
constexpr double kPartSpeed_mps = 0.05;  // plus a share of the speed, 99 % and rotation
constexpr double kPartSpeedShare = 0.03;
constexpr double kPartChi2 = 11.34;
constexpr int kOutweighs = 2;

bool move_as_one(const MovingObject& a, const MovingObject& b) {
  const double slack_mps = kPartSpeed_mps + kPartSpeedShare * std::max(a.speed_mps, b.speed_mps);
  const Eigen::Vector3d dv = a.velocity_mps - b.velocity_mps;
  const Eigen::Matrix3d S = a.velocity_covariance_m2ps2 + b.velocity_covariance_m2ps2 +
                            slack_mps * slack_mps / kPartChi2 * Eigen::Matrix3d::Identity();
  return dv.dot(S.inverse() * dv) < kPartChi2;
}

}  // namespace

ObjectTable::Tracked* ObjectTable::by_tracks(std::span<const PointSample> points, Members members) {
  Tracked* best = nullptr;
  std::ptrdiff_t best_shared = 0;
  for (Tracked& tracked : objects_) {
    const std::ptrdiff_t shared = std::count_if(members.begin(), members.end(), [&](auto i) {
      return owners_[points[i].track] == tracked.object.id;
    });
    // A part that was found beside what is confirmed becomes part of that.
    const std::ptrdiff_t weight = tracked.confirmed ? kConfirmedWeight * shared : shared;
    if (weight > best_shared) {
      best = &tracked;
      best_shared = weight;
    }
  }
  return best;
}

bool ObjectTable::is_pure(std::span<const PointSample> points, Members members,
                          double share) const {
  return purity_of(points, members) >= share * config_.min_purity;
}

Eigen::Vector3d ObjectTable::space_between(const Box& a, const Box& b) {
  return ((a.centre_m - b.centre_m).cwiseAbs() - 0.5 * (a.size_m + b.size_m)).cwiseMax(0.0);
}

bool ObjectTable::is_known(const Tracked& tracked) const {
  return tracked.confirmed && to_seconds(now_ - tracked.first) >= kKnown_s;
}

// What has been known for an object for some time becomes no echo of what it passes.
bool ObjectTable::carries_on(std::span<const PointSample> points, Members members,
                             const Tracked& tracked) const {
  if (!is_known(tracked)) return false;
  const auto own = std::count_if(members.begin(), members.end(), [&](auto i) {
    return owners_[points[i].track] == tracked.object.id;
  });
  return 2 * own > static_cast<std::ptrdiff_t>(members.size());
}

// Of what is large another side may be seen, as far behind the last one as it is wide.
bool ObjectTable::is_another_side(const Tracked& tracked, const MotionGroup& group) const {
  const Eigen::Vector3d gap_m = space_between(tracked.box, {group.centre_m, group.size_m});
  return is_known(tracked) && tracked.object.state == ObjectState::kCoasting &&
         tracked.width_m > kLarge_m && gap_m.head<2>().norm() < config_.neighbour_distance_m &&
         gap_m.z() < tracked.width_m;
}

ObjectTable::Tracked* ObjectTable::by_place(const MotionGroup& group) {
  Tracked* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (Tracked& tracked : objects_) {
    if (tracked.evident) continue;
    const double unseen_s = to_seconds(now_ - tracked.last_evidence);
    const double off_m = (tracked.box.centre_m - group.centre_m).norm();
    const bool at_place = off_m < kReclaimDistance_m + kReclaimDrift_mps * unseen_s ||
                          is_another_side(tracked, group);
    // What has stopped may set off at any speed.
    const bool at_speed = tracked.object.state == ObjectState::kStopped ||
                          (tracked.object.velocity_mps - group.velocity_mps).norm() <
                              kReclaimSpeed_mps + kReclaimSpeedShare * group.velocity_mps.norm();
    if (at_place && at_speed && off_m < nearest_m) {
      nearest = &tracked;
      nearest_m = off_m;
    }
  }
  return nearest;
}

// A group beside an object with many more points, in one body with it, or a thin one at one that
// has been known for some time: an arm or a leg.
bool ObjectTable::is_limb(const MotionGroup& group) const {
  return std::any_of(objects_.begin(), objects_.end(), [&](const Tracked& tracked) {
    const bool is_thin = group.size_m.x() < kLimbWidth_m;
    const bool is_seen = to_seconds(now_ - tracked.last_evidence) < kLimbMemory_s;
    const auto trunk = trunk_in(tracked.box);
    if (is_thin && is_seen && is_known(tracked) && trunk &&
        hangs_on(group.centre_m, *trunk, kLimbSwing_m))
      return true;
    return tracked.evident && tracked.body == group.body &&
           kLimbRatio * group.count < tracked.group;
  });
}

// Over a long interval repeated texture is mismatched in shoals, among points that rest.
double ObjectTable::least_purity() const {
  return is_slow_ ? std::max(kLeapPurity, config_.min_purity) : config_.min_purity;
}

// Only a group that passes every gate opens an object; later a smaller one keeps it. What swings
// its limbs may show few points of one velocity: then all that move there count.
ObjectTable::Tracked* ObjectTable::create(const StereoCamera& camera,
                                          std::span<const PointSample> points,
                                          const MotionGroup& group, const MotionGroups& finder) {
  const auto least = static_cast<std::size_t>(config_.min_points);
  const MotionBody& body = finder.bodies()[group.body];
  const bool swings = group.count < least && !group.leaps && group.leads && !group.with_rig &&
                      body.count >= least &&
                      purity_of(points, finder.members(body)) >= config_.min_purity;
  if ((group.count < least && !swings) || is_limb(group) || group.purity < least_purity() ||
      group.recedes || group.chi2() < config_.object_chi2 || group.evidence < gates_.min_evidence ||
      line_motion(camera, points, finder.members(body)).along_line ||
      lies_on_unseen_border(camera, group, points) || lies_under_ground(group, points)) {
    return nullptr;
  }
  Tracked tracked;
  tracked.swings = swings;
  const auto lost = lost_.take(group.centre_m, group.velocity_mps);
  if (lost) std::erase_if(objects_, [&](const Tracked& t) { return t.object.id == lost->id; });
  if (objects_.size() == kMostObjects) {
    if (lost) lost_.give_back(lost->id);
    return nullptr;
  }
  tracked.object.id = lost ? lost->id : ++last_id_;
  tracked.first_seen = lost ? lost->first_seen : now_;
  tracked.object.position_m = group.position_m;
  tracked.object.rectangle = group.rectangle;
  tracked.first = now_;
  tracked.last_evidence = now_;
  objects_.push_back(tracked);
  return &objects_.back();
}

// Something beside it has set off, and was taken for a part of it while its motion was not clear.
bool ObjectTable::stands_apart(std::span<const PointSample> points, const MotionGroup& group,
                               const Tracked& tracked) const {
  if (!tracked.evident || tracked.swings) return false;
  const Box box{group.centre_m, group.size_m};
  const double sigma_m = std::sqrt(2.0 * tracked.object.position_covariance_m2(2, 2));
  return !are_near(tracked.box, box, sigma_m) &&
         are_seen_past(points, {tracked.box, tracked.own_rectangle}, {box, group.rectangle});
}

// Of what its tracks lead to first: who has come back, or is new, is found among the rest.
void ObjectTable::associate(const StereoCamera& camera, std::span<const PointSample> points,
                            const MotionGroups& finder, std::span<const MotionGroup> groups,
                            bool is_slow) {
  is_slow_ = is_slow;
  const auto counts = [&](const MotionGroup& group) {
    return !group.slides && group.velocity_mps.norm() >= gates_.min_speed_mps;
  };
  for (const MotionGroup& group : groups) {
    if (!counts(group)) continue;
    const Members members = finder.members(group);
    Tracked* tracked = by_tracks(points, members);
    if (tracked == nullptr) continue;
    if ((group.echoes || group.slips) && !carries_on(points, members, *tracked)) continue;
    if (stands_apart(points, group, *tracked)) {
      disown(points, members);
    } else {
      join(points, members, group, *tracked);
    }
  }
  for (Tracked& tracked : objects_) {
    if (!tracked.evident && tracked.confirmed && !tracked.swings)
      go_on_by_tracks(points, finder, tracked);
    if (!tracked.evident && tracked.confirmed) go_on_as_expected(points, finder, tracked);
  }
  for (const MotionGroup& group : groups) {
    if (!counts(group) || group.echoes || group.slips) continue;
    const Members members = finder.members(group);
    if (by_tracks(points, members) != nullptr) continue;
    Tracked* tracked = by_place(group);
    if (tracked == nullptr) tracked = create(camera, points, group, finder);
    if (tracked != nullptr) join(points, members, group, *tracked);
  }
  for (Tracked& tracked : objects_) {
    if (tracked.swings) adopt_limbs(camera, points, tracked);
  }
}

void ObjectTable::disown(std::span<const PointSample> points, Members members) {
  for (const auto i : members) owners_[points[i].track] = 0;
}

void ObjectTable::join(std::span<const PointSample> points, Members members,
                       const MotionGroup& group, Tracked& tracked) {
  if (!tracked.evident) {
    take_group(group, tracked);
  } else if (!tracked.swings) {
    tracked.box = joined(tracked.box, {group.centre_m, group.size_m});
  }
  for (const auto i : members) owners_[points[i].track] = tracked.object.id;
}

// Who sets off or turns is not where its points were due, most of which say nothing of motion by
// themselves for a while, or is at different velocities by them, since each has a past of its own.
// They are still its own, do not rest, and most of them agree.
void ObjectTable::go_on_by_tracks(std::span<const PointSample> points, const MotionGroups& finder,
                                  Tracked& tracked) {
  std::size_t own = 0;
  members_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (owners_[points[i].track] != tracked.object.id) continue;
    ++own;
    if (points[i].chi2 > gates_.moving_chi2 && !points[i].stands)
      members_.push_back(static_cast<Grouper::Index>(i));
  }
  const auto least = static_cast<std::size_t>(config_.min_points);
  if (members_.size() < least) return;
  const double rho = config_.error_correlation;
  const Eigen::Vector3d rough_mps = weighted_velocity(points, members_, rho).velocity_mps;
  std::erase_if(members_, [&](auto i) { return velocity_chi2(points[i], rough_mps) >= kGoOnChi2; });
  if (members_.size() < least || 2 * members_.size() < own || !is_pure(points, members_)) return;
  const MeanVelocity mean = weighted_velocity(points, members_, rho);
  if (mean.velocity_mps.norm() < gates_.min_speed_mps) return;
  MotionGroup group;
  group.count = members_.size();
  group.body = finder.body_of(points, members_);
  group.centre_m = centre_of(points, members_);
  group.size_m = extent_of(points, members_);
  group.rectangle = rectangle_of(points, members_);
  group.velocity_mps = mean.velocity_mps;
  group.velocity_covariance_m2ps2 = mean.covariance_m2ps2;
  group.evidence = joint_evidence(points, members_, rho);
  take_group(group, tracked);
}

// Of somebody far away, or behind something, few points are seen. Where each of them surely moves,
// and as the object was due to, it is seen; unless as many rest.
void ObjectTable::go_on_as_expected(std::span<const PointSample> points, const MotionGroups& finder,
                                    Tracked& tracked) {
  std::size_t resting = 0;
  members_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PointSample& point = points[i];
    if (owners_[point.track] != tracked.object.id || point.left_only) continue;
    resting += point.stands ? 1 : 0;
    const bool surely_moves = point.moves && point.chi2 > kMovingAloneChi2;
    if (surely_moves && is_at(point, tracked.box) &&
        velocity_chi2(point, tracked.object.velocity_mps) < kGoOnChi2)
      members_.push_back(static_cast<Grouper::Index>(i));
  }
  if (members_.size() < kFewPoints || members_.size() <= resting) return;
  tracked.evident = tracked.by_few = true;
  tracked.group = members_.size();
  tracked.body = finder.body_of(points, members_);
  tracked.evidence =
      add_evidence(tracked.evidence, joint_evidence(points, members_, config_.error_correlation));
}

// Whose velocity was known a moment ago does not leap: an arm or a leg does.
bool ObjectTable::is_of_limb(const MotionGroup& group, const Tracked& tracked) const {
  const double leap_mps = (group.velocity_mps - tracked.object.velocity_mps).norm();
  return tracked.swings && tracked.confirmed &&
         to_seconds(now_ - tracked.last_velocity) < kVelocityMemory_s &&
         leap_mps > std::max(kLeap_mps, kLeapShare * tracked.object.speed_mps);
}

void ObjectTable::take_group(const MotionGroup& group, Tracked& tracked) {
  tracked.evident = true;
  tracked.group = group.count;
  tracked.body = group.body;
  tracked.box = {group.centre_m, group.size_m};
  tracked.own_rectangle = group.rectangle;
  tracked.evidence = add_evidence(tracked.evidence, group.evidence);
  if (tracked.confirmed) lost_.erase(tracked.object.id);
  if (is_of_limb(group, tracked)) return;
  tracked.object.velocity_mps = group.velocity_mps;
  tracked.object.velocity_covariance_m2ps2 = group.velocity_covariance_m2ps2;
}

// Arms and legs belong to whom they hang on, whatever their velocity: moving points of nobody's at
// the object. While the trunk's own points are too few, they say that it goes on.
void ObjectTable::adopt_limbs(const StereoCamera& camera, std::span<const PointSample> points,
                              Tracked& tracked) {
  const MovingObject& object = tracked.object;
  const auto margin_px = static_cast<float>(kLimbReach_m * camera.fx_px / object.position_m.z());
  const PixelRect& r = object.rectangle;
  const float below_px = kUpright * margin_px;
  const PixelRect around{r.u_min_px - margin_px, r.v_min_px - below_px, r.u_max_px + margin_px,
                         r.v_max_px + below_px};
  std::size_t moving = 0;
  for (const PointSample& point : points) {
    std::int64_t& owner = owners_[point.track];
    if (!point.moves || (owner != 0 && owner != object.id) || !contains(around, point.pixel_px) ||
        !is_at(point, tracked.box)) {
      continue;
    }
    owner = object.id;
    ++moving;
  }
  tracked.by_limbs = !tracked.evident && tracked.confirmed && moving >= MotionGroups::kLeastPoints;
  tracked.evident = tracked.evident || tracked.by_limbs;
}

// A large body shows its texture in islands further apart than neighbours are: of two objects with
// one velocity, whose gap is small for their size and shows nothing behind, one is part of the
// other. The younger one, unless it has been known for some time and outweighs the other: a limb of
// somebody may have been taken for who was here before.
bool ObjectTable::is_part(std::span<const PointSample> points, const Tracked& older,
                          const Tracked& younger) const {
  const double sigma_m = std::sqrt(older.object.position_covariance_m2(2, 2) +
                                   younger.object.position_covariance_m2(2, 2));
  return older.evident && younger.evident && are_near(older.box, younger.box, sigma_m) &&
         move_as_one(older.object, younger.object) &&
         !are_seen_past(points, {older.box, older.own_rectangle},
                        {younger.box, younger.own_rectangle});
}

void ObjectTable::absorb_parts(const StereoCamera& camera, std::span<const PointSample> points) {
  for (std::size_t older = 0; older < objects_.size(); ++older) {
    bool has_parts = false;
    for (std::size_t younger = older + 1; younger < objects_.size();) {
      Tracked& whole = objects_[older];
      Tracked& part = objects_[younger];
      if (!is_part(points, whole, part)) {
        ++younger;
        continue;
      }
      if (is_known(part) && part.object.points > kOutweighs * whole.object.points)
        std::swap(whole, part);
      std::replace(owners_.begin(), owners_.end(), part.object.id, whole.object.id);
      whole.confirmed = whole.confirmed || part.confirmed;
      lost_.give_back(part.object.id);
      objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(younger));
      has_parts = true;
    }
    Tracked& whole = objects_[older];
    if (!has_parts) continue;
    collect(points, whole);
    if (!members_.empty()) measure(camera, points, whole);
    if (whole.confirmed) whole.object.state = ObjectState::kMoving;
  }
}

}  // namespace egomod
