// SPDX-License-Identifier: Apache-2.0
#include "capture/pairing.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace egomod {
namespace {

// Index of the entry of ascending `times` nearest to `t`; the earlier of two equally near.
std::optional<std::size_t> nearest(std::span<const Nanoseconds> times, Nanoseconds t) {
  if (times.empty()) return std::nullopt;
  const auto next = static_cast<std::size_t>(
      std::distance(times.begin(), std::lower_bound(times.begin(), times.end(), t)));
  if (next == 0) return 0;
  if (next == times.size()) return next - 1;
  return times[next] - t < t - times[next - 1] ? next : next - 1;
}

template <typename Intervals>
Nanoseconds median_of(Intervals& intervals, std::size_t count) {
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(intervals.begin(), middle,
                   intervals.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace

std::optional<Nanoseconds> median_interval(std::span<const Nanoseconds> times) {
  if (times.size() < 2) return std::nullopt;
  std::vector<Nanoseconds> intervals;
  intervals.reserve(times.size());
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  return median_of(intervals, intervals.size());
}

Nanoseconds skew_limit(double configured_s, std::span<const Nanoseconds> left,
                       std::span<const Nanoseconds> right) {
  if (configured_s > 0.0) return Nanoseconds(std::llround(configured_s * 1e9));
  if (const auto interval = median_interval(left)) return *interval / 2;
  if (const auto interval = median_interval(right)) return *interval / 2;
  return kUnknownIntervalLimit;
}

std::vector<Partner> pair_by_exposure(std::span<const Nanoseconds> left,
                                      std::span<const Nanoseconds> right, Nanoseconds limit) {
  std::vector<Partner> partners(left.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    const auto r = nearest(right, left[i]);
    if (!r) continue;
    const bool is_mutual = nearest(left, right[*r]) == i;
    partners[i] = {r, is_mutual && std::chrono::abs(right[*r] - left[i]) <= limit};
  }
  return partners;
}

void IntervalMeter::add(Nanoseconds interval) { intervals_[count_++ % kWindow] = interval; }

std::optional<Nanoseconds> IntervalMeter::median() const {
  if (count_ == 0) return std::nullopt;
  auto sorted = intervals_;
  return median_of(sorted, std::min(count_, kWindow));
}

std::optional<Nanoseconds> IntervalMeter::typical() const {
  if (count_ == 0 || count_ > kFew) return median();
  return *std::min_element(intervals_.begin(),
                           intervals_.begin() + static_cast<std::ptrdiff_t>(count_));
}

RateLimiter::RateLimiter(double max_rate_hz)
    : period_(max_rate_hz > 0.0 ? std::llround(1e9 / max_rate_hz) : 0) {}

bool RateLimiter::is_due(Nanoseconds exposure) {
  if (last_seen_ && exposure > *last_seen_) interval_.add(exposure - *last_seen_);
  const bool stepped_back = last_seen_ && exposure < *last_seen_;
  last_seen_ = exposure;
  if (!last_kept_ || stepped_back) return true;
  const Nanoseconds half = interval_.median().value_or(Nanoseconds(0)) / 2;
  return exposure - *last_kept_ >= period_ - half;
}

}  // namespace egomod
