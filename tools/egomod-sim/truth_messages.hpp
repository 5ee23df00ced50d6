// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>

#include "simulator.hpp"

namespace egomod::sim {

inline constexpr const char* kTruthPoseChannel = "SIM_TRUTH_POSE";
inline constexpr const char* kTruthObjectsChannel = "SIM_TRUTH_OBJECTS";

// Truth of left image `sequence`, from left camera axes to body and world frame. Each refills
// `message`. Objects that are hidden are in the list with the centre of their box as position, no
// visible pixel, and a rectangle that holds none (its minimum lies beyond its maximum).
void fill_message(const Truth& truth, const Eigen::Isometry3d& T_body_camera, std::int64_t utime,
                  std::int64_t sequence, truth_pose_t& message);
void fill_message(const Truth& truth, const Eigen::Isometry3d& T_body_camera, std::int64_t utime,
                  std::int64_t sequence, truth_object_list_t& message);

}  // namespace egomod::sim
