// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/channels.hpp"
#include "capture/image_message.hpp"
#include "capture/live_pairing.hpp"
#include "egomod/core/calibration.hpp"

namespace egomod {

// Keeps the images that come from the bus until the source takes them as pairs: a bounded store of
// buffers that grow to the largest message and stay.
// Threads: `receive` from the bus's thread, the rest from the source's.
class ImageReceiver {
 public:
  struct Slot {
    ImageRecord record;
    std::vector<std::uint8_t> bytes;
    Nanoseconds arrival{0};
  };
  struct Counters {
    std::uint64_t lost_images = 0;       // gaps in the exposures of the left camera
    std::uint64_t dropped_images = 0;    // came too late, or the store was full
    std::uint64_t damaged_messages = 0;  // of a wrong type, or not whole
    std::size_t largest_message_bytes = 0;
  };

  ImageReceiver(const CaptureConfig& config, bool wants_calibration);

  void receive(const std::string& channel, std::span<const std::uint8_t> message);

  // A first calibration that comes from elsewhere than the bus. Threads: any.
  void provide(const Calibration& calibration);
  // Waits for the first calibration; nothing if asked to stop.
  [[nodiscard]] std::optional<Calibration> wait_for_calibration(const std::stop_token& stop);
  // Waits for the next left image with its partner; nothing if asked to stop. Its slots stay
  // untouched until `give_back`.
  [[nodiscard]] std::optional<LivePairing::Decision> wait_for_pair(const std::stop_token& stop);
  [[nodiscard]] const Slot& slot(std::size_t index) const { return slots_[index]; }
  void give_back(const LivePairing::Decision& decision);

  [[nodiscard]] Counters counters() const;
  // Why the last calibration that came could not be the first; empty if none was refused.
  [[nodiscard]] std::string calibration_fault() const;
  // Whether a message held two images of one camera, which is left out.
  [[nodiscard]] bool is_ambiguous() const;
  [[nodiscard]] const ImageChannels& channels() const { return channels_; }

 private:
  void receive_calibration(std::span<const std::uint8_t> message);
  void receive_images(const std::string& channel, std::span<const std::uint8_t> message);
  void store(const ImageRecord& record, std::span<const std::uint8_t> message, bool is_left);
  void free(std::optional<std::size_t> slot);

  // Both queues of the pairing, one pair in work, one image coming in.
  static constexpr std::size_t kSlots = 20;

  const ImageChannels channels_;
  bool wants_calibration_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Calibration> calibration_;
  std::string calibration_fault_;
  bool is_ambiguous_ = false;
  LivePairing pairing_;
  std::array<Slot, kSlots> slots_;
  std::array<std::size_t, kSlots> free_slots_{};
  std::size_t free_count_ = kSlots;
  Counters counters_;
};

}  // namespace egomod
