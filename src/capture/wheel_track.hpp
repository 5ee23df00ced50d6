// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "egomod/core/time.hpp"
#include "egomod/core/wheels.hpp"

namespace egomod {

inline constexpr const char* kOdometryChannel = "PIONEER_ODOMETRY";

// What one egomod.odometry_t says of where the base stands.
struct WheelReading {
  Nanoseconds time{0};
  std::int64_t sequence = 0;
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;
};

// Nothing for what is no odometry_t, or not finite.
[[nodiscard]] std::optional<WheelReading> decode_odometry(std::span<const std::uint8_t> message);

// The odometry of the last seconds, read at the times of exposures, never of arrivals: between two
// readings along the arc that joins them, shortly after the last along the last arc. Threads: one
// caller.
class WheelTrack {
 public:
  // `max_age_s`: neither two readings that are joined nor the last one and an exposure lie further
  // apart.
  explicit WheelTrack(double max_age_s);

  // A base that starts counting anew, or jumps, begins a new stretch; what is older than the last
  // reading, but not by a step of the clock, is left out.
  void add(const WheelReading& reading);
  [[nodiscard]] std::optional<WheelPose> at(Nanoseconds exposure) const;
  // What has come already tells all about the exposure.
  [[nodiscard]] bool reaches(Nanoseconds exposure) const {
    return count_ > 0 && last().time >= exposure;
  }

 private:
  // 5 s of the 100 Hz that a base sends at most.
  static constexpr std::size_t kCapacity = 512;

  [[nodiscard]] const WheelReading& reading(std::size_t index) const {
    return readings_[(first_ + index) % kCapacity];
  }
  [[nodiscard]] const WheelReading& last() const { return reading(count_ - 1); }
  [[nodiscard]] bool breaks_off(const WheelReading& next) const;

  Nanoseconds max_age_;
  std::vector<WheelReading> readings_;  // a ring, ascending
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint32_t stretch_ = 0;
};

// The same for what is there as a whole: readings in the order of their arrival, ascending times to
// read them at.
[[nodiscard]] std::vector<std::optional<WheelPose>> wheel_poses(
    std::span<const WheelReading> readings, std::span<const Nanoseconds> exposures,
    double max_age_s);

}  // namespace egomod
