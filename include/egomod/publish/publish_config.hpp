// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/bus/bus_address.hpp"

namespace egomod {

enum class ImageEncoding { kNone, kRaw, kJpeg };

struct PublishConfig {
  ImageEncoding images = ImageEncoding::kNone;  // EGOMOD_IMAGES: rectified pairs
  int jpeg_quality = 90;                        // 1..100
  bool tracks = false;                          // EGOMOD_TRACKS
};

// Where messages go.
struct PublishTarget {
  BusAddress lcm_url{};        // LCM's own default has TTL 0
  std::string record{};        // log file, overwritten; empty: none
  bool record_timing = false;  // EGOMOD_TIMING in the record, which then differs from run to run
  // Live: timing goes to the bus, a bus that cannot be opened is tried again, and a record that
  // cannot be written stops while the rest goes on.
  bool live = false;
};

}  // namespace egomod
