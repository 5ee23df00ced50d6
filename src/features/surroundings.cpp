// SPDX-License-Identifier: Apache-2.0
#include "surroundings.hpp"

#include <numeric>

namespace egomod {

void Surroundings::sort(const TrackStore& store) {
  points_ = &store.points();
  cells_.clear();
  starts_.fill(0);
  for (const FollowedPoint& point : *points_) {
    const std::size_t at = cell(cell_along(point.left.u_px), cell_along(point.left.v_px));
    cells_.push_back(static_cast<std::uint32_t>(at));
    ++starts_[at + 1];
  }
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  places_.resize(cells_.size());
  // From the last on, each takes the last free place of its cell.
  std::array<std::uint32_t, kCells * kCells> ends;
  std::copy(starts_.begin() + 1, starts_.end(), ends.begin());
  for (std::size_t i = cells_.size(); i > 0; --i)
    places_[--ends[cells_[i - 1]]] = {(*points_)[i - 1].left, static_cast<std::uint32_t>(i - 1)};
}

}  // namespace egomod
