// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/lost_objects.hpp"

#include <algorithm>
#include <limits>

namespace egomod {
namespace {

constexpr std::size_t kMost = 32;
constexpr double kMemory_s = 6.0;  // of one that moved, which may go anywhere
constexpr double kStoppedMemory_s = 60.0;
constexpr double kReach_m = 0.5;
constexpr double kReachGrowth_mps = 0.6;  // with the time unseen
constexpr double kTurn_mps = 0.3;         // its velocity may have become another by this,
constexpr double kTurnShare = 0.1;        // a share of the speed,
constexpr double kTurn_mps2 = 0.3;        // and the time unseen

}  // namespace

LostObjects::LostObjects() { objects_.reserve(kMost); }

void LostObjects::move_on(Nanoseconds now, const Eigen::Isometry3d& T_current_previous) {
  const double elapsed_s = to_seconds(now - now_);
  now_ = now;
  std::erase_if(objects_, [&](const LostObject& object) {
    const double unseen_s = to_seconds(now_ - object.last_seen);
    return unseen_s > (object.stopped ? kStoppedMemory_s : kMemory_s);
  });
  for (LostObject& object : objects_) {
    object.centre_m = T_current_previous * (object.centre_m + elapsed_s * object.velocity_mps);
    object.velocity_mps = T_current_previous.linear() * object.velocity_mps;
  }
}

void LostObjects::remember(const LostObject& object) {
  erase(object.id);
  if (objects_.size() == kMost) objects_.erase(objects_.begin());
  objects_.push_back(object);
}

// What has stopped is where it was, and sets off at any speed.
bool LostObjects::may_be(const LostObject& object, const Eigen::Vector3d& centre_m,
                         const Eigen::Vector3d& velocity_mps) const {
  const double unseen_s = object.stopped ? 0.0 : to_seconds(now_ - object.last_seen);
  const double turn_mps = kTurn_mps + kTurnShare * velocity_mps.norm() + kTurn_mps2 * unseen_s;
  return (object.centre_m - centre_m).norm() < kReach_m + kReachGrowth_mps * unseen_s &&
         (object.stopped || (object.velocity_mps - velocity_mps).norm() < turn_mps);
}

const LostObject* LostObjects::find(const Eigen::Vector3d& centre_m,
                                    const Eigen::Vector3d& velocity_mps) const {
  const LostObject* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const LostObject& object : objects_) {
    const double off_m = (object.centre_m - centre_m).norm();
    if (off_m < nearest_m && may_be(object, centre_m, velocity_mps)) {
      nearest = &object;
      nearest_m = off_m;
    }
  }
  return nearest;
}

void LostObjects::erase(std::int64_t id) {
  std::erase_if(objects_, [&](const LostObject& object) { return object.id == id; });
}

}  // namespace egomod
