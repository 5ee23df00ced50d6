// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "egomod/core/frame.hpp"
#include "egomod/pipeline/latency_histogram.hpp"

namespace egomod {

// A snapshot; counts since the start.
struct PipelineStatistics {
  std::uint64_t captured = 0;  // pairs that came from the source, rejected and skipped ones too
  std::uint64_t rejected = 0;  // pairs that capture could not use
  std::array<std::uint64_t, kPairFaults> rejected_by{};  // index: PairFault
  std::uint64_t skipped = 0;                             // pairs left out by capture.max_rate_hz
  std::uint64_t dropped = 0;         // overtaken by a newer pair before features
  std::uint64_t dropped_usable = 0;  // those of them that were neither rejected nor skipped
  std::uint64_t published = 0;       // pairs that reached the end
  Nanoseconds last_skew{0};
  Nanoseconds max_skew{0};             // largest magnitude
  Nanoseconds least_rejected_skew{0};  // smallest magnitude of those beyond the limit; 0: none
  std::array<LatencySummary, kStageCount> stages{};
  LatencySummary total{};  // from the arrival of a pair to the end of its publication
};

// What the stages count. Threads: each counter has one writing stage; `snapshot` from any thread.
class PipelineCounters {
 public:
  void count_captured(const StereoPair& pair);
  void count_dropped(const StereoPair& pair);
  void count_published(const Frame& frame);
  void count_time(Stage stage, const StageTime& time);

  [[nodiscard]] std::uint64_t published() const { return published_.load(); }
  [[nodiscard]] PipelineStatistics snapshot() const;

 private:
  void count_rejected(const StereoPair& pair);

  using Counter = std::atomic<std::uint64_t>;
  static void bump(Counter& counter) { counter.store(counter.load() + 1); }

  Counter captured_{0};
  Counter rejected_{0};
  std::array<Counter, kPairFaults> rejected_by_{};
  Counter skipped_{0};
  Counter dropped_{0};
  Counter dropped_usable_{0};
  Counter published_{0};
  std::atomic<std::int64_t> last_skew_ns_{0};
  std::atomic<std::int64_t> max_skew_ns_{0};
  std::atomic<std::int64_t> least_rejected_skew_ns_{0};
  std::array<LatencyHistogram, kStageCount> stages_;
  LatencyHistogram total_;
};

}  // namespace egomod
