// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/images_t.hpp>
#include <egomod/calibration_t.hpp>
#include <egomod/object_list_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/timing_t.hpp>
#include <egomod/track_list_t.hpp>
#include <egomod/velocity_t.hpp>

#include "egomod/core/frame.hpp"

namespace egomod {

// From left camera frames to the body frame (x forward, y left, z up) and the world frame, which is
// the body frame of the first pair. Each refills `message`, so that its memory is used again.

// T_world_body of the pair: T_body_camera * T_first_current * T_body_camera^-1.
[[nodiscard]] Eigen::Isometry3d world_from_body(const Frame& frame);

void fill_message(const Frame& frame, pose_t& message);
void fill_message(const Frame& frame, velocity_t& message);
// Objects that hold a number that is not finite are left out; returns how many.
int fill_message(const Frame& frame, object_list_t& message);
// The tracks seen in this pair; those that hold a number that is not finite are left out; returns
// how many.
int fill_message(const Frame& frame, track_list_t& message);
// `publish_end`: host monotonic clock.
void fill_message(const Frame& frame, Nanoseconds publish_end, timing_t& message);
// What `images_are_raw` says is about EGOMOD_IMAGES beside it, not about the calibration's source.
void fill_message(const Calibration& calibration, bool images_are_raw, calibration_t& message);

// The inverse; exact. Rotations and sizes are taken as they stand: checking is the receiver's.
[[nodiscard]] Calibration calibration_from(const calibration_t& message);

// No NaN, no infinity.
[[nodiscard]] bool is_finite(const pose_t& message);
[[nodiscard]] bool is_finite(const velocity_t& message);
[[nodiscard]] bool is_finite(const calibration_t& message);

}  // namespace egomod
