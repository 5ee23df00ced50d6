// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/latency_histogram.hpp"

#include <algorithm>
#include <bit>

namespace egomod {

// Values below kSubBuckets have a bucket each; above, the bits behind the leading one choose among
// the kSubBuckets of its octave.
std::size_t LatencyHistogram::bucket_of(std::uint64_t duration_ns) {
  if (duration_ns < kSubBuckets) {
    return duration_ns;
  }
  const int octave = static_cast<int>(std::bit_width(duration_ns)) - 1 - kSubBucketBits;
  const std::size_t sub_bucket = (duration_ns >> octave) - kSubBuckets;
  return std::min((static_cast<std::size_t>(octave) + 1) * kSubBuckets + sub_bucket, kBuckets - 1);
}

Nanoseconds LatencyHistogram::middle_of(std::size_t bucket) {
  if (bucket < kSubBuckets) {
    return Nanoseconds(bucket);
  }
  const std::size_t octave = bucket / kSubBuckets - 1;
  const std::uint64_t low = (kSubBuckets + bucket % kSubBuckets) << octave;
  return Nanoseconds(low + ((std::uint64_t{1} << octave) >> 1U));
}

void LatencyHistogram::add(Nanoseconds duration) {
  const std::int64_t duration_ns = std::max<std::int64_t>(duration.count(), 0);
  auto& bucket = buckets_[bucket_of(static_cast<std::uint64_t>(duration_ns))];
  bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  max_ns_.store(std::max(max_ns_.load(std::memory_order_relaxed), duration_ns),
                std::memory_order_relaxed);
}

LatencySummary LatencyHistogram::summary() const {
  std::array<std::uint64_t, kBuckets> counts{};
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    counts[i] = buckets_[i].load(std::memory_order_relaxed);
    total += counts[i];
  }
  const Nanoseconds max(max_ns_.load(std::memory_order_relaxed));
  const auto quantile = [&](std::uint64_t percent) {
    const std::uint64_t rank = (total * percent + 99) / 100;
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += counts[i];
      if (seen >= rank) {
        return std::min(middle_of(i), max);
      }
    }
    return max;
  };
  if (total == 0) {
    return {};
  }
  return {.count = total, .p50 = quantile(50), .p99 = quantile(99), .max = max};
}

}  // namespace egomod
