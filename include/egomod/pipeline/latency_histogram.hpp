// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "egomod/core/time.hpp"

namespace egomod {

struct LatencySummary {
  std::uint64_t count = 0;
  Nanoseconds p50{0};
  Nanoseconds p99{0};
  Nanoseconds max{0};
};

// Durations in buckets that are 1/16 of their power of two wide: a quantile is within 1/32 of the
// truth, the maximum is exact. Fixed size. Threads: one writer, any number of readers.
class LatencyHistogram {
 public:
  void add(Nanoseconds duration);
  [[nodiscard]] LatencySummary summary() const;

 private:
  static constexpr int kSubBucketBits = 4;
  static constexpr std::size_t kSubBuckets = std::size_t{1} << kSubBucketBits;
  static constexpr std::size_t kOctaves = 40;  // up to 2^40 ns, 18 minutes
  static constexpr std::size_t kBuckets = kSubBuckets * kOctaves;

  [[nodiscard]] static std::size_t bucket_of(std::uint64_t duration_ns);
  [[nodiscard]] static Nanoseconds middle_of(std::size_t bucket);

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace egomod
