// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "egomod/core/time.hpp"
#include "egomod/core/wheels.hpp"

namespace egomod {

enum class PairStatus : std::uint8_t {
  kOk,
  kSkipped,   // dropped before features by capture.max_rate_hz; images may be empty
  kRejected,  // no right image within the skew limit, or an image that cannot be used
};

// Why a pair was rejected.
enum class PairFault : std::uint8_t {
  kNone,
  kNoPartner,  // there is no right image
  kSkew,       // the nearest right image lies beyond the limit; `right_exposure` is its time
  kDamaged,    // an image cannot be decoded, or is not of the calibration's size
};
inline constexpr std::size_t kPairFaults = 4;

// What a source hands along for the bus and the record, encoded already, such as the truth of a
// rendered world. No stage looks into it.
struct EnclosedMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  bool is_for_bus = true;  // false: for the record only, since the bus has it already
};

// Left and right image of one instant, rectified. Every left image becomes one of these, also when
// it cannot be used, so that subscribers and poses.txt can count.
struct StereoPair {
  std::uint64_t sequence = 0;  // zero-based index of the left image
  Nanoseconds exposure{0};     // middle of the left exposure
  Nanoseconds right_exposure{0};
  Nanoseconds epoch_offset{
      0};                  // exposure + epoch_offset: since the epoch; 0 in replays and on the bus
  Nanoseconds arrival{0};  // host monotonic clock, when the pair was complete
  PairStatus status = PairStatus::kOk;
  PairFault fault = PairFault::kNone;
  bool discontinuity =
      false;  // the stream broke before this pair (clock step, camera lost): re-seed
  Calibration calibration;
  Image left;
  Image right;
  std::optional<WheelPose> wheels{};        // at the exposure, if odometry comes
  std::vector<EnclosedMessage> enclosed{};  // in the order in which they are published

  [[nodiscard]] Nanoseconds skew() const { return right_exposure - exposure; }
  // The pair's time on the bus, microseconds.
  [[nodiscard]] std::int64_t utime_us() const {
    return std::chrono::duration_cast<std::chrono::microseconds>(exposure + epoch_offset).count();
  }
};

}  // namespace egomod
