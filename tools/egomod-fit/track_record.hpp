// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <egomod/track_list_t.hpp>
#include <functional>
#include <string>

#include "record.hpp"

namespace egomod::fit {

// One pair of a record.
struct TrackedPair {
  track_list_t list;
  double depth_times_disparity = 0.0;  // m px
  double rig_speed_mps = 0.0;          // since the pair before; the last one where unknown

  [[nodiscard]] eval::PointEvidence point(const track_t& track) const;
};

// Hands over the EGOMOD_TRACKS of a record, one pair after the other. Returns why the record ended
// before its file did; empty if it is whole. Throws InputError where there are none.
[[nodiscard]] std::string for_each_tracked_pair(const std::string& log,
                                                const std::function<void(const TrackedPair&)>& use);

}  // namespace egomod::fit
