// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

// How the daemon and the egomod-sim that it starts talk: pixels lie in shared memory, all else goes
// as packets through a Unix socket (SOCK_SEQPACKET) that the daemon gives its child. So both sleep
// until there is something to do, and each sees at once that the other is gone.
//
//   egomod-sim  Hello, calibration_t behind it; the memory's descriptor goes along (SCM_RIGHTS)
//   daemon      Request: the next images, please; these slots are free
//   egomod-sim  Shot: an image lies in a slot; behind a left one truth_pose_t,
//               truth_object_list_t and, where the rig stands on a driven base, odometry_t
//   egomod-sim  Signal, kAnswered: that was all, which may be less than two images
//   egomod-sim  End: the world is over
//
// In lockstep the world stands still until it is requested. By the wall clock the first request
// starts it, the later ones only say which slots are free, and none is answered. Calibration and
// truth are encoded as LCM does; the rest is of one machine and one build, so that structs travel
// as they lie in memory.
namespace egomod::sim_protocol {

inline constexpr std::uint32_t kVersion = 2;
// As many images as the pairing can hold, one in work, some on their way.
inline constexpr std::uint32_t kSlots = 20;
inline constexpr std::size_t kMaxPacketBytes = std::size_t{64} * 1024;
// The descriptor that the child finds the socket at.
inline constexpr int kSocket = 3;

enum class Kind : std::uint32_t { kHello = 1, kRequest, kShot, kAnswered, kEnd };
enum class Eye : std::uint32_t { kLeft, kRight };

struct Hello {
  Kind kind = Kind::kHello;
  std::uint32_t version = kVersion;
  std::uint64_t pairs = 0;       // 0: endless
  std::uint64_t slot_bytes = 0;  // slot i begins at i * slot_bytes
};

struct Request {
  Kind kind = Kind::kRequest;
  std::uint32_t free_slots = 0;  // bit i: slot i has become free
};

struct Shot {
  Kind kind = Kind::kShot;
  Eye eye = Eye::kLeft;
  std::uint32_t slot = 0;
  std::int32_t width_px = 0;
  std::int32_t height_px = 0;
  std::int32_t stride_bytes = 0;
  std::int64_t exposure_us = 0;  // its middle; simulated time
  // Left images are numbered in order of exposure, also those that are left out for want of time.
  std::uint64_t sequence = 0;
  std::uint32_t truth_pose_bytes = 0;
  std::uint32_t truth_objects_bytes = 0;
  std::uint32_t odometry_bytes = 0;  // 0: no wheels
  std::uint32_t reserved = 0;
};

struct Signal {
  Kind kind = Kind::kAnswered;
};

struct End {
  Kind kind = Kind::kEnd;
  std::uint32_t reserved = 0;
  std::uint64_t left_images = 0;  // of the whole world, also those that were left out
};

template <typename Packet>
inline constexpr bool is_packet =
    std::is_trivially_copyable_v<Packet>&& std::has_unique_object_representations_v<Packet>;
static_assert(is_packet<Hello> && is_packet<Request> && is_packet<Shot> && is_packet<Signal> &&
              is_packet<End>);
static_assert(kSlots <= 32, "Request::free_slots has a bit for each");

}  // namespace egomod::sim_protocol
