// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "egomod/core/time.hpp"

namespace egomod {

// Median of the differences of neighbours; nothing for fewer than two times.
[[nodiscard]] std::optional<Nanoseconds> median_interval(std::span<const Nanoseconds> times);

// Where nothing tells the frame interval, it is taken to be that of 10 Hz, slow for a moving rig.
inline constexpr Nanoseconds kUnknownIntervalLimit = std::chrono::milliseconds(50);

// The skew up to which two exposures are one instant: `configured_s`, or, if that is 0, half the
// frame interval of either camera; without any interval kUnknownIntervalLimit.
[[nodiscard]] Nanoseconds skew_limit(double configured_s, std::span<const Nanoseconds> left,
                                     std::span<const Nanoseconds> right);

struct Partner {
  std::optional<std::size_t> nearest;  // index of the right exposure nearest in time
  bool accepted = false;               // within the limit, and no other left one is nearer to it
};

// The partner of each left exposure. Both spans ascend; of two equally near the earlier wins.
[[nodiscard]] std::vector<Partner> pair_by_exposure(std::span<const Nanoseconds> left,
                                                    std::span<const Nanoseconds> right,
                                                    Nanoseconds limit);

// Median of the last intervals of a stream, without allocation.
class IntervalMeter {
 public:
  void add(Nanoseconds interval);
  [[nodiscard]] std::optional<Nanoseconds> median() const;
  // As the median, but of the first few the smallest: what is lost or late makes them longer only.
  [[nodiscard]] std::optional<Nanoseconds> typical() const;
  // Of so few that it may well be twice as long as it should be.
  [[nodiscard]] bool is_young() const { return count_ <= 1; }

 private:
  static constexpr std::size_t kWindow = 15;
  static constexpr std::size_t kFew = 4;
  std::array<Nanoseconds, kWindow> intervals_{};
  std::size_t count_ = 0;
};

// Thins a stream out to `max_rate_hz` (0: not at all). The first pair stays, then each one at least
// 1/rate minus half a pair interval after the last that stayed, so that jitter cannot turn every
// 6th into every 7th.
class RateLimiter {
 public:
  explicit RateLimiter(double max_rate_hz);
  // Whether the pair is due; to be asked once for each pair, in order of exposure.
  [[nodiscard]] bool is_due(Nanoseconds exposure);
  // The pair of the last question stayed.
  void keep(Nanoseconds exposure) { last_kept_ = exposure; }

 private:
  Nanoseconds period_;
  IntervalMeter interval_;
  std::optional<Nanoseconds> last_seen_;
  std::optional<Nanoseconds> last_kept_;
};

}  // namespace egomod
