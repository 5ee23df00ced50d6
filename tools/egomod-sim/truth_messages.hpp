// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>

#include "simulator.hpp"

namespace egomod::sim {

// What `truth` says of the instant t_s, as SIM_TRUTH_POSE and SIM_TRUTH_OBJECTS carry it. Each
// refills `message`, so that its memory is used again; utime and sequence are the caller's.
void fill_message(const Simulator& simulator, double t_s, const Truth& truth,
                  truth_pose_t& message);
void fill_message(const Simulator& simulator, double t_s, const Truth& truth,
                  truth_object_list_t& message);

}  // namespace egomod::sim
