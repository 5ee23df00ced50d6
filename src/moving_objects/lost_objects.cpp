// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/lost_objects.hpp"

#include <algorithm>
#include <limits>

namespace egomod {
namespace {

constexpr std::size_t kMost = 32;
constexpr double kMemory_s = 4.0;  // of one that moved, beyond the time that objects coast
constexpr double kStoppedMemory_s = 60.0;
// From where its velocity has brought it, growing with the time unseen up to the most.
constexpr double kReach_m = 0.5;
constexpr double kReachGrowth_mps = 0.6;
constexpr double kMostReach_m = 2.0;
// By so much its velocity may have become another one, likewise; but it has not turned round.
constexpr double kTurn_mps = 0.3;
constexpr double kTurnShare = 0.1;  // of the speed
constexpr double kTurnGrowth_mps2 = 0.3;
constexpr double kMostTurn_mps = 0.8;

bool has_stopped(const LostObject& object) { return object.velocity_mps.isZero(0.0); }

}  // namespace

LostObjects::LostObjects() { entries_.reserve(kMost); }

void LostObjects::move_on(Nanoseconds now, const Eigen::Isometry3d& T_current_previous) {
  const double elapsed_s = to_seconds(now - now_);
  now_ = now;
  if (elapsed_s < 0.0) return clear();
  std::erase_if(entries_, [&](const Entry& entry) {
    return to_seconds(now_ - entry.lost) >
           (has_stopped(entry.object) ? kStoppedMemory_s : kMemory_s);
  });
  for (Entry& entry : entries_) {
    LostObject& object = entry.object;
    object.centre_m = T_current_previous * (object.centre_m + elapsed_s * object.velocity_mps);
    object.velocity_mps = T_current_previous.linear() * object.velocity_mps;
  }
}

void LostObjects::remember(const LostObject& object) {
  erase(object.id);
  if (entries_.size() == kMost) entries_.erase(entries_.begin());
  entries_.push_back({object, now_});
}

// What has stopped is where it was, and sets off at any speed and to anywhere.
bool LostObjects::may_be(const LostObject& object, const Eigen::Vector3d& centre_m,
                         const Eigen::Vector3d& velocity_mps) const {
  const double off_m = (object.centre_m - centre_m).norm();
  if (has_stopped(object)) return off_m < kReach_m;
  const double unseen_s = to_seconds(now_ - object.last_seen);
  const double turn_mps = std::min(kTurn_mps + kTurnGrowth_mps2 * unseen_s, kMostTurn_mps) +
                          kTurnShare * velocity_mps.norm();
  return off_m < std::min(kReach_m + kReachGrowth_mps * unseen_s, kMostReach_m) &&
         (object.velocity_mps - velocity_mps).norm() < turn_mps &&
         object.velocity_mps.dot(velocity_mps) > 0.0;
}

std::optional<LostObject> LostObjects::take(const Eigen::Vector3d& centre_m,
                                            const Eigen::Vector3d& velocity_mps) {
  Entry* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (Entry& entry : entries_) {
    const double off_m = (entry.object.centre_m - centre_m).norm();
    if (entry.is_taken || off_m >= nearest_m || !may_be(entry.object, centre_m, velocity_mps))
      continue;
    nearest = &entry;
    nearest_m = off_m;
  }
  if (nearest == nullptr) return std::nullopt;
  nearest->is_taken = true;
  return nearest->object;
}

void LostObjects::give_back(std::int64_t id) {
  for (Entry& entry : entries_)
    if (entry.object.id == id) entry.is_taken = false;
}

void LostObjects::erase(std::int64_t id) {
  std::erase_if(entries_, [&](const Entry& entry) { return entry.object.id == id; });
}

}  // namespace egomod
