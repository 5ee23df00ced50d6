// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/filter_bank.hpp"

#include "moving_objects/point_sample.hpp"

namespace egomod {

FilterBank::FilterBank() {
  filters_.reserve(kReservedTracks);
  free_.reserve(kReservedTracks);
  places_.reserve(kReservedTracks);
  previous_places_.reserve(kReservedTracks);
}

void FilterBank::clear() {
  for (const Place& place : places_) free_.push_back(place.filter);
  places_.clear();
}

void FilterBank::align(std::span<const Track> tracks) {
  places_.swap(previous_places_);
  places_.clear();
  auto old = previous_places_.begin();
  const auto free_before = [&](std::uint64_t id) {
    for (; old != previous_places_.end() && old->track_id < id; ++old) free_.push_back(old->filter);
  };
  for (const Track& track : tracks) {
    free_before(track.id);
    if (old != previous_places_.end() && old->track_id == track.id) {
      places_.push_back(*old++);
      continue;
    }
    if (free_.empty()) {
      free_.push_back(filters_.size());
      filters_.emplace_back();
    }
    places_.push_back({track.id, free_.back()});
    filters_[free_.back()].updates = 0;
    free_.pop_back();
  }
  for (; old != previous_places_.end(); ++old) free_.push_back(old->filter);
}

}  // namespace egomod
