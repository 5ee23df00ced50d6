// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/track_set.hpp"
#include "moving_objects/track_filter.hpp"

namespace egomod {

// The filters of the living tracks. A filter keeps its place in memory as long as its track lives.
class FilterBank {
 public:
  FilterBank();

  void clear();
  // Frees the filters of dead tracks, takes free ones for new tracks.
  void align(std::span<const Track> tracks);
  // Of tracks[track] of the last `align`.
  // Brings the filter of a track near; past the last one, nothing.
  void prefetch(std::size_t track) const {
    constexpr std::size_t kCacheLine = 64;
    if (track >= places_.size()) return;
    const auto* bytes = reinterpret_cast<const char*>(&filters_[places_[track].filter]);
    for (std::size_t i = 0; i < sizeof(TrackFilter); i += kCacheLine) __builtin_prefetch(bytes + i);
  }
  [[nodiscard]] TrackFilter& of(std::size_t track) { return filters_[places_[track].filter]; }

 private:
  struct Place {
    std::uint64_t track_id;
    std::size_t filter;
  };

  std::vector<TrackFilter> filters_;
  std::vector<std::size_t> free_;
  std::vector<Place> places_;  // ascending id
  std::vector<Place> previous_places_;
};

}  // namespace egomod
