// SPDX-License-Identifier: Apache-2.0
#include "capture/live_pairing.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace egomod {
namespace {

constexpr Nanoseconds kReordering = std::chrono::seconds(1);
// At any rate of pictures: two of one camera are one that came twice.
constexpr Nanoseconds kSurelyTogether = std::chrono::milliseconds(2);
// A right image so far ahead of the left ones has a wrong time.
constexpr Nanoseconds kFarAhead = std::chrono::minutes(1);

}  // namespace

std::optional<std::size_t> LivePairing::Queue::insert(Entry entry) {
  std::optional<std::size_t> displaced;
  if (count == kCapacity) displaced = take(0).slot;
  std::size_t at = count;
  while (at > 0 && entries[at - 1].exposure > entry.exposure) {
    entries[at] = entries[at - 1];
    --at;
  }
  entries[at] = entry;
  ++count;
  return displaced;
}

LivePairing::Entry LivePairing::Queue::take(std::size_t index) {
  const Entry taken = entries[index];
  std::copy(entries.begin() + static_cast<std::ptrdiff_t>(index) + 1,
            entries.begin() + static_cast<std::ptrdiff_t>(count),
            entries.begin() + static_cast<std::ptrdiff_t>(index));
  --count;
  return taken;
}

bool LivePairing::Queue::has(Nanoseconds exposure) const {
  return std::any_of(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const Entry& entry) {
                       return std::chrono::abs(entry.exposure - exposure) < kSurelyTogether;
                     });
}

std::optional<std::size_t> LivePairing::add_left(Entry entry) {
  if (left_.has(entry.exposure)) return entry.slot;
  if (last_left_ && entry.exposure <= *last_left_) {
    if (entry.exposure > *last_left_ - kReordering) return entry.slot;
    step_back(entry.exposure);
  }
  return left_.insert(entry);
}

// What waits belongs to the old time, and would sort behind all that comes.
void LivePairing::step_back(Nanoseconds exposure) {
  has_stepped_back_ = true;
  last_left_.reset();
  last_right_.reset();
  for (Queue* queue : {&left_, &right_}) {
    while (queue->count > 0 && queue->entries[queue->count - 1].exposure > exposure + kReordering &&
           stale_count_ < stale_.size()) {
      stale_[stale_count_++] = queue->take(queue->count - 1).slot;
    }
  }
}

std::optional<std::size_t> LivePairing::add_right(Entry entry) {
  const auto newest_left =
      left_.count > 0 ? std::optional(left_.entries[left_.count - 1].exposure) : last_left_;
  if (right_.has(entry.exposure) || (newest_left && entry.exposure > *newest_left + kFarAhead))
    return entry.slot;
  if (last_right_ && entry.exposure > *last_right_ + kSurelyTogether)
    right_interval_.add(entry.exposure - *last_right_);
  last_right_ = std::max(entry.exposure, last_right_.value_or(entry.exposure));
  return right_.insert(entry);
}

std::optional<std::size_t> LivePairing::nearest_right(Nanoseconds exposure) const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < right_.count; ++i) {
    const auto skew = std::chrono::abs(right_.entries[i].exposure - exposure);
    if (!best || skew < std::chrono::abs(right_.entries[*best].exposure - exposure)) best = i;
  }
  return best;
}

// Two breaks of the stream that are equally long are its new rate.
void LivePairing::learn_gap(Nanoseconds gap, bool is_break) {
  const bool is_rate =
      is_break && last_break_ && 10 * std::chrono::abs(gap - *last_break_) < *last_break_;
  last_break_ = is_break ? std::optional(gap) : std::nullopt;
  if (is_rate) {
    interval_ = {};
    right_interval_ = {};
  }
  if (!is_break || is_rate) interval_.add(gap);
}

void LivePairing::note_gap(Decision& decision) {
  const Nanoseconds exposure = decision.left.exposure;
  const auto interval = interval_.median();
  if (last_left_) {
    const Nanoseconds gap = exposure - *last_left_;
    if (interval && *interval > Nanoseconds(0)) {
      const auto steps = (gap + *interval / 2) / *interval;
      decision.lost = steps > 1 ? static_cast<std::uint64_t>(steps - 1) : 0;
      decision.discontinuity = gap > kHoleIntervals * *interval;
    }
    learn_gap(gap, decision.discontinuity);
  }
  decision.discontinuity = decision.discontinuity || has_stepped_back_;
  has_stepped_back_ = false;
  last_left_ = exposure;
}

Nanoseconds LivePairing::Queue::smallest_gap() const {
  Nanoseconds smallest = Nanoseconds::max();
  for (std::size_t i = 1; i < count; ++i)
    smallest = std::min(smallest, entries[i].exposure - entries[i - 1].exposure);
  return smallest;
}

// The shorter one of the two cameras, since loss makes it longer only; at first by the images that
// wait.
std::optional<Nanoseconds> LivePairing::interval() const {
  const Nanoseconds right = right_interval_.typical().value_or(Nanoseconds::max());
  if (const auto left = interval_.typical()) return std::min(*left, right);
  Nanoseconds gap = std::min(left_.smallest_gap(), right);
  if (last_left_) gap = std::min(gap, left_.entries[0].exposure - *last_left_);
  return gap == Nanoseconds::max() ? std::nullopt : std::optional(gap);
}

std::optional<LivePairing::Decision> LivePairing::decide() {
  if (left_.count == 0) return std::nullopt;
  const Nanoseconds exposure = left_.entries[0].exposure;
  const auto nearest = nearest_right(exposure);
  const auto interval = this->interval();
  // Of an interval that is twice the true one, the image of the next instant is half away.
  const Nanoseconds half = !interval              ? kUnknownIntervalLimit
                           : interval_.is_young() ? 2 * *interval / 5
                                                  : *interval / 2;
  const Nanoseconds limit = max_skew_s_ > 0.0 ? Nanoseconds(std::llround(max_skew_s_ * 1e9)) : half;
  const bool has_passed = right_.count > 0 && right_.entries[right_.count - 1].exposure >= exposure;
  const Nanoseconds skew =
      nearest ? Nanoseconds(std::chrono::abs(right_.entries[*nearest].exposure - exposure))
              : Nanoseconds::max();
  const bool is_near = nearest && interval_.median() && skew <= std::min(limit, half);
  const bool waits = !has_ended_ && left_.count < kMaxWaiting;
  if (!is_near && !has_passed && waits) return std::nullopt;
  // Of the first pair one image may be late, and the next one of its camera no partner.
  if (!interval && skew > kSurelyTogether && max_skew_s_ <= 0.0 && waits) return std::nullopt;
  Decision decision;
  decision.left = left_.take(0);
  if (nearest) decision.nearest_right = right_.entries[*nearest].exposure;
  decision.is_accepted = nearest && skew <= limit;
  if (decision.is_accepted) decision.right = right_.take(*nearest);
  note_gap(decision);
  return decision;
}

std::optional<std::size_t> LivePairing::take_stale() {
  if (stale_count_ > 0) return stale_[--stale_count_];
  const auto interval = interval_.median();
  if (!last_left_ || !interval || right_.count == 0) return std::nullopt;
  // What is older still may be the first image after a step of the clock, ahead of its left one.
  const Nanoseconds age = *last_left_ - right_.entries[0].exposure;
  if (age < *interval || age > kReordering) return std::nullopt;
  return right_.take(0).slot;
}

}  // namespace egomod
