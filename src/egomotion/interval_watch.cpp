// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/interval_watch.hpp"

#include <algorithm>

namespace egomod {
namespace {

// Of the usual interval: one missing pair makes it twice as long, jitter a third.
constexpr double kLate = 1.6;

}  // namespace

bool IntervalWatch::is_late(Nanoseconds exposure) {
  const Nanoseconds interval = exposure - last_exposure_;
  const bool known = started_ && interval > Nanoseconds(0);
  const bool late = known && count_ > 0 && to_seconds(interval) > kLate * to_seconds(usual());
  if (known) intervals_[count_++ % intervals_.size()] = interval;
  started_ = true;
  last_exposure_ = exposure;
  return late;
}

// The median forgets a hole at once; as long as the last one is what a new rate has.
Nanoseconds IntervalWatch::usual() const {
  const Nanoseconds last = intervals_[(count_ - 1) % intervals_.size()];
  if (count_ < intervals_.size()) return last;
  std::array<Nanoseconds, 3> sorted = intervals_;
  std::sort(sorted.begin(), sorted.end());
  return std::max(sorted[1], last);
}

}  // namespace egomod
