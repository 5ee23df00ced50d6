// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/core/stereo_pair.hpp"
#include "egomod/core/time.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod {

enum class Stage : std::size_t { kCapture, kFeatures, kEgomotion, kMovingObjects, kPublish };
inline constexpr std::size_t kStageCount = 5;
[[nodiscard]] const char* name(Stage stage);

// Host monotonic clock.
struct StageTime {
  Nanoseconds start{0};
  Nanoseconds end{0};
};

// One slot of the pool: a pair and all that the stages make of it, each filling its own member in
// place. The slot belongs to the one stage that holds its pointer.
struct Frame {
  StereoPair pair;
  TrackSet tracks;
  Egomotion motion;
  MovingObjects objects;
  std::array<StageTime, kStageCount> times{};
};

}  // namespace egomod
