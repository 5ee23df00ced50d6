// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/filter_bank.hpp"

#include <algorithm>
#include <iterator>

#include "egomod/core/instruction_set.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

FilterKernels filter_kernels() {
#if defined(EGOMOD_HAS_X86_64_V3)
  if (instruction_set() >= InstructionSet::kX86_64V3) return x86_64_v3::filter_kernels();
#endif
  return baseline::filter_kernels();
}

namespace {

void prefetch(const FilterBlock& block) {
  constexpr std::size_t kCacheLine = 64;
  const auto* bytes = reinterpret_cast<const char*>(&block);
  for (std::size_t i = 0; i < sizeof(block); i += kCacheLine) __builtin_prefetch(bytes + i, 1);
}

}  // namespace

FilterBank::FilterBank() {
  constexpr std::size_t kBlocks = kReservedTracks / kFilterLanes;
  filters_.reserve(kBlocks);
  measurements_.reserve(kBlocks);
  points_.reserve(kBlocks);
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
    if (free_.empty()) add_block();
    places_.push_back({track.id, free_.back()});
    const std::size_t filter = free_.back();
    filters_[filter / kFilterLanes].updates[filter % kFilterLanes] = 0.0;
    free_.pop_back();
  }
  for (; old != previous_places_.end(); ++old) free_.push_back(old->filter);
  for (MeasurementBlock& block : measurements_)
    std::fill(std::begin(block.is_seen), std::end(block.is_seen), 0.0);
}

// The first of its lanes is taken first.
void FilterBank::add_block() {
  const std::size_t first = filters_.size() * kFilterLanes;
  for (std::size_t lane = kFilterLanes; lane > 0; --lane) free_.push_back(first + lane - 1);
  filters_.push_back({});
  measurements_.push_back({});
  points_.push_back({});
}

void FilterBank::step(const FilterStep& step) {
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    if (i + 1 < filters_.size()) prefetch(filters_[i + 1]);
    const Lanes& seen = measurements_[i].is_seen;
    const bool any =
        std::any_of(std::begin(seen), std::end(seen), [](double x) { return x != 0.0; });
    if (any) kernels_.step(step, measurements_[i], filters_[i], points_[i]);
  }
}

}  // namespace egomod
