// SPDX-License-Identifier: Apache-2.0
// Which object each group of moving points belongs to, and which groups open a new one.
#include <algorithm>
#include <cmath>
#include <limits>

#include "egomod/moving_objects/evidence_gates.hpp"
#include "moving_objects/object_table.hpp"

namespace egomod {
namespace {

constexpr double kReclaimDistance_m = 0.5;  // an object without tracks is found again this near,
constexpr double kReclaimDrift_mps = 0.3;   // growing with the time that it was unseen,
constexpr double kReclaimSpeed_mps = 0.3;   // at a velocity this similar
constexpr double kReclaimSpeedShare = 0.1;
constexpr double kLeapPurity = 0.8;  // of what opens an object over a long interval
constexpr std::size_t kLimbRatio = 2;
constexpr double kLimbWidth_m = 0.3;
constexpr double kLimbSwing_m = 0.55;  // beside the trunk
constexpr double kLimbMemory_s = 0.3;
constexpr double kVelocityMemory_s = 0.4;  // about half a step
constexpr double kLeap_mps = 0.5;
constexpr double kLeapShare = 0.4;
constexpr double kLimbReach_m = 0.3;  // from the rectangle
constexpr float kUpright = 3.0F;      // of that, up and down

}  // namespace

ObjectTable::Tracked* ObjectTable::by_tracks(std::span<const PointSample> points, Members members) {
  Tracked* best = nullptr;
  std::ptrdiff_t best_shared = 0;
  for (Tracked& tracked : objects_) {
    const std::ptrdiff_t shared = std::count_if(members.begin(), members.end(), [&](auto i) {
      return owners_[points[i].track] == tracked.object.id;
    });
    if (shared > best_shared) {
      best = &tracked;
      best_shared = shared;
    }
  }
  return best;
}

// What has been known for an object for some time becomes no echo of what it passes.
bool ObjectTable::carries_on(std::span<const PointSample> points, Members members,
                             const Tracked* tracked) const {
  if (tracked == nullptr || !tracked->confirmed || to_seconds(now_ - tracked->first) < kKnown_s)
    return false;
  const auto own = std::count_if(members.begin(), members.end(), [&](auto i) {
    return owners_[points[i].track] == tracked->object.id;
  });
  return 2 * own > static_cast<std::ptrdiff_t>(members.size());
}

ObjectTable::Tracked* ObjectTable::by_place(const MotionGroup& group) {
  Tracked* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (Tracked& tracked : objects_) {
    if (tracked.evident) continue;
    const double unseen_s = to_seconds(now_ - tracked.last_evidence);
    const double off_m = (tracked.box.centre_m - group.centre_m).norm();
    const bool at_place = off_m < kReclaimDistance_m + kReclaimDrift_mps * unseen_s;
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
    const bool is_thin =
        group.size_m.x() < kLimbWidth_m && to_seconds(now_ - tracked.first) > kKnown_s;
    const bool is_seen = to_seconds(now_ - tracked.last_evidence) < kLimbMemory_s;
    const auto trunk = trunk_in(tracked.box);
    if (is_thin && is_seen && tracked.confirmed && trunk &&
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
      objects_.size() == kMostObjects ||
      line_motion(camera, points, finder.members(body)).along_line ||
      lies_on_unseen_border(camera, group, points) || lies_under_ground(group, points)) {
    return nullptr;
  }
  Tracked tracked;
  tracked.swings = swings;
  const auto lost = lost_.take(group.centre_m, group.velocity_mps);
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

void ObjectTable::associate(const StereoCamera& camera, std::span<const PointSample> points,
                            const MotionGroups& finder, std::span<const MotionGroup> groups,
                            bool is_slow) {
  is_slow_ = is_slow;
  for (const MotionGroup& group : groups) {
    if (group.slides || group.velocity_mps.norm() < gates_.min_speed_mps) continue;
    const Members members = finder.members(group);
    Tracked* tracked = by_tracks(points, members);
    if ((group.echoes || group.slips) && !carries_on(points, members, tracked)) continue;
    if (tracked == nullptr) tracked = by_place(group);
    const bool is_apart = tracked != nullptr && stands_apart(points, group, *tracked);
    if (tracked == nullptr || is_apart) tracked = create(camera, points, group, finder);
    if (is_apart && tracked == nullptr) {
      for (const auto i : members) owners_[points[i].track] = 0;
    }
    if (tracked == nullptr) continue;
    if (!tracked->evident) {
      take_group(group, *tracked);
    } else if (!tracked->swings) {
      tracked->box = joined(tracked->box, {group.centre_m, group.size_m});
    }
    for (const auto i : members) owners_[points[i].track] = tracked->object.id;
  }
  for (Tracked& tracked : objects_) {
    if (tracked.swings) adopt_limbs(camera, points, tracked);
  }
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

}  // namespace egomod
