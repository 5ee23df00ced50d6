// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "capture/pairing.hpp"
#include "egomod/core/time.hpp"

namespace egomod {

// Pairs two live streams by exposure. Images are known by the slots that hold them.
// A left image is decided on as soon as no right one to come can be nearer: at once if the skew is
// within half a frame interval, else when the right stream has passed it, or when it has waited for
// `kMaxWaiting` left images. Allocates nothing. Threads: one caller.
class LivePairing {
 public:
  static constexpr std::size_t kMaxWaiting = 4;
  static constexpr int kHoleIntervals = 10;  // a gap this long counts as a break of the stream

  struct Entry {
    Nanoseconds exposure{0};
    std::size_t slot = 0;
  };
  struct Decision {
    Entry left;
    std::optional<Entry> right;                // if accepted; the caller gives back its slot
    std::optional<Nanoseconds> nearest_right;  // also when it is too far away
    bool is_accepted = false;
    bool discontinuity = false;
    std::uint64_t lost = 0;  // left images that the gap before this one has swallowed
  };

  // 0: half a frame interval.
  explicit LivePairing(double max_skew_s) : max_skew_s_(max_skew_s) {}

  // Adds an image; a slot that has to leave for it, or the image itself if it comes too late, twice
  // or with a wrong time, is returned.
  [[nodiscard]] std::optional<std::size_t> add_left(Entry entry);
  [[nodiscard]] std::optional<std::size_t> add_right(Entry entry);

  // No further image comes: what waits is decided on as it is.
  void end() { has_ended_ = true; }
  // The oldest left image that can be decided on.
  [[nodiscard]] std::optional<Decision> decide();
  // The slot of an image that nobody can need any more.
  [[nodiscard]] std::optional<std::size_t> take_stale();

 private:
  // Ascending; full: the oldest leaves.
  struct Queue {
    static constexpr std::size_t kCapacity = 8;
    [[nodiscard]] std::optional<std::size_t> insert(Entry entry);
    [[nodiscard]] Entry take(std::size_t index);
    [[nodiscard]] bool has(Nanoseconds exposure) const;
    [[nodiscard]] Nanoseconds smallest_gap() const;  // max() where there is none
    std::array<Entry, kCapacity> entries{};
    std::size_t count = 0;
  };

  [[nodiscard]] std::optional<std::size_t> nearest_right(Nanoseconds exposure) const;
  [[nodiscard]] std::optional<Nanoseconds> interval() const;  // while a left image waits
  void learn_gap(Nanoseconds gap, bool is_break);
  void note_gap(Decision& decision);
  void step_back(Nanoseconds exposure);

  double max_skew_s_;
  Queue left_;
  Queue right_;
  std::array<std::size_t, 2 * Queue::kCapacity> stale_{};
  std::size_t stale_count_ = 0;
  IntervalMeter interval_;
  IntervalMeter right_interval_;
  std::optional<Nanoseconds> last_left_;
  std::optional<Nanoseconds> last_right_;
  std::optional<Nanoseconds> last_break_;
  bool has_stepped_back_ = false;
  bool has_ended_ = false;
};

}  // namespace egomod
