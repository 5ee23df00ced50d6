// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capture/calibration_message.hpp"
#include "capture/image_message.hpp"
#include "capture/log_file.hpp"
#include "egomod/capture/capture_config.hpp"
#include "egomod/core/wheels.hpp"

namespace egomod {

// An image of the log. `record.data_offset` counts from the start of the file.
struct LogImage {
  ImageRecord record{};
  int segment = 0;          // grows where the clock steps back by more than the reordering window
  bool is_damaged = false;  // of its message only the time could be read
};

struct LogPair {
  LogImage left;
  std::optional<LogImage> right;  // the nearest one
  bool is_accepted = false;       // within the skew limit
  bool discontinuity = false;     // the first pair of a new segment
  std::optional<WheelPose> wheels{};

  [[nodiscard]] bool is_damaged() const { return left.is_damaged || (right && right->is_damaged); }
};

// All that a log has for capture, found in one pass that touches no pixels.
struct LogIndex {
  std::vector<LogPair> pairs;                  // in order of exposure
  std::vector<TimedCalibration> calibrations;  // in order of the log
  std::uint64_t untimed_messages = 0;          // so damaged that they could not become pairs
};

inline constexpr Nanoseconds kReorderingWindow = std::chrono::seconds(1);

// Reads `log` from its beginning. Throws SourceError on a wrong type on a channel in use.
[[nodiscard]] LogIndex index_log(LogFile& log, const CaptureConfig& config);

}  // namespace egomod
