// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/track_set.hpp"
#include "moving_objects/filter_kernels.hpp"

namespace egomod {

// A filter's place: lane `lane` of block `block`.
struct FilterSlot {
  std::size_t block = 0;
  std::size_t lane = 0;
};

// The filters of the living tracks, as many side by side as the kernels take. A filter keeps its
// place in memory as long as its track lives.
class FilterBank {
 public:
  FilterBank();

  void clear();
  // Frees the filters of dead tracks, takes free ones for new tracks. None is seen yet.
  void align(std::span<const Track> tracks);
  // Of tracks[track] of the last `align`.
  [[nodiscard]] FilterSlot slot(std::size_t track) const {
    return {places_[track].filter / kFilterLanes, places_[track].filter % kFilterLanes};
  }
  [[nodiscard]] MeasurementBlock& measurements(FilterSlot at) { return measurements_[at.block]; }
  [[nodiscard]] const MeasurementBlock& measurements(FilterSlot at) const {
    return measurements_[at.block];
  }
  // Takes what is measured into the filters that are seen.
  void step(const FilterStep& step);
  [[nodiscard]] const FilterBlock& filters(FilterSlot at) const { return filters_[at.block]; }
  [[nodiscard]] const PointBlock& points(FilterSlot at) const { return points_[at.block]; }

 private:
  struct Place {
    std::uint64_t track_id;
    std::size_t filter;
  };

  void add_block();

  const FilterKernels kernels_ = filter_kernels();
  std::vector<FilterBlock> filters_;
  std::vector<MeasurementBlock> measurements_;
  std::vector<PointBlock> points_;
  std::vector<std::size_t> free_;
  std::vector<Place> places_;  // ascending id
  std::vector<Place> previous_places_;
};

}  // namespace egomod
