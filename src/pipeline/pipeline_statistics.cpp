// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/pipeline_statistics.hpp"

#include <algorithm>
#include <cstdlib>

namespace egomod {

void PipelineCounters::count_captured(const StereoPair& pair) {
  bump(captured_);
  if (pair.status == PairStatus::kRejected) {
    count_rejected(pair);
    return;
  }
  if (pair.status == PairStatus::kSkipped) {
    bump(skipped_);
    return;
  }
  const std::int64_t skew_ns = pair.skew().count();
  last_skew_ns_.store(skew_ns);
  max_skew_ns_.store(std::max(max_skew_ns_.load(), skew_ns < 0 ? -skew_ns : skew_ns));
}

void PipelineCounters::count_rejected(const StereoPair& pair) {
  bump(rejected_);
  bump(rejected_by_[static_cast<std::size_t>(pair.fault)]);
  if (pair.fault != PairFault::kSkew) return;
  const std::int64_t least_ns = least_rejected_skew_ns_.load();
  const std::int64_t skew_ns = std::abs(pair.skew().count());
  least_rejected_skew_ns_.store(least_ns == 0 ? skew_ns : std::min(least_ns, skew_ns));
}

void PipelineCounters::count_dropped(const StereoPair& pair) {
  bump(dropped_);
  if (pair.status == PairStatus::kOk) bump(dropped_usable_);
}

void PipelineCounters::count_published(const Frame& frame) {
  bump(published_);
  if (frame.pair.status == PairStatus::kOk) {
    total_.add(frame.times[static_cast<std::size_t>(Stage::kPublish)].end - frame.pair.arrival);
  }
}

void PipelineCounters::count_time(Stage stage, const StageTime& time) {
  stages_[static_cast<std::size_t>(stage)].add(time.end - time.start);
}

PipelineStatistics PipelineCounters::snapshot() const {
  PipelineStatistics statistics{.captured = captured_.load(),
                                .rejected = rejected_.load(),
                                .skipped = skipped_.load(),
                                .dropped = dropped_.load(),
                                .dropped_usable = dropped_usable_.load(),
                                .published = published_.load(),
                                .last_skew = Nanoseconds(last_skew_ns_.load()),
                                .max_skew = Nanoseconds(max_skew_ns_.load()),
                                .least_rejected_skew = Nanoseconds(least_rejected_skew_ns_.load()),
                                .total = total_.summary()};
  for (std::size_t i = 0; i < kPairFaults; ++i) {
    statistics.rejected_by[i] = rejected_by_[i].load();
  }
  for (std::size_t i = 0; i < kStageCount; ++i) {
    statistics.stages[i] = stages_[i].summary();
  }
  return statistics;
}

}  // namespace egomod
