// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"

namespace egomod {

// Which tracks move on their own, and which of them move as one. Threads: one caller.
class MovingObjectDetector {
 public:
  explicit MovingObjectDetector(const MovingObjectsConfig& config);
  ~MovingObjectDetector();

  // `objects` is refilled in place; velocities are finite whatever comes in. Without a valid
  // egomotion nothing becomes MOVING. `has_run` is false for a skipped pair only: a rejected one,
  // which was not tracked either, has its list.
  void detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace egomod
