// SPDX-License-Identifier: Apache-2.0
#include "capture/image_receiver.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "capture/calibration_check.hpp"
#include "capture/calibration_message.hpp"

namespace egomod {

ImageReceiver::ImageReceiver(const CaptureConfig& config, bool wants_calibration)
    : channels_(config), wants_calibration_(wants_calibration), pairing_(config.max_skew_s) {
  std::iota(free_slots_.begin(), free_slots_.end(), std::size_t{0});
}

void ImageReceiver::receive(const std::string& channel, std::span<const std::uint8_t> message) {
  {
    const std::lock_guard lock(mutex_);
    if (channel == kCalibrationChannel) {
      receive_calibration(message);
    } else {
      receive_images(channel, message);
    }
  }
  changed_.notify_all();
}

void ImageReceiver::receive_calibration(std::span<const std::uint8_t> message) {
  if (!wants_calibration_) return;
  const auto decoded = decode_calibration(message);
  calibration_fault_ =
      decoded ? fault_of(decoded->calibration) : "it is not an egomod.calibration_t";
  if (!calibration_fault_.empty()) {
    ++counters_.damaged_messages;
    return;
  }
  calibration_ = decoded->calibration;
  wants_calibration_ = false;
}

void ImageReceiver::receive_images(const std::string& channel,
                                   std::span<const std::uint8_t> message) {
  counters_.largest_message_bytes = std::max(counters_.largest_message_bytes, message.size());
  MemoryReader reader(message);
  StereoRecord found;
  if (channel == channels_.both) {
    const MessageState state = find_images(reader, found);
    if (state != MessageState::kOk) ++counters_.damaged_messages;
    if (state == MessageState::kAmbiguous) {
      is_ambiguous_ = true;
      return;
    }
  } else {
    ImageRecord one;
    if (find_image(reader, one) == MessageState::kOk) {
      (channel == channels_.left ? found.left : found.right) = one;
    } else {
      ++counters_.damaged_messages;
    }
  }
  if (found.right) store(*found.right, message, false);
  if (found.left) store(*found.left, message, true);
}

void ImageReceiver::store(const ImageRecord& record, std::span<const std::uint8_t> message,
                          bool is_left) {
  if (free_count_ == 0) {
    ++counters_.dropped_images;
    return;
  }
  const std::size_t index = free_slots_[--free_count_];
  Slot& slot = slots_[index];
  const auto data =
      message.subspan(record.data_offset, static_cast<std::size_t>(record.size_bytes));
  slot.record = record;
  slot.bytes.assign(data.begin(), data.end());
  slot.arrival = std::chrono::steady_clock::now().time_since_epoch();
  const LivePairing::Entry entry{record.exposure(), index};
  const auto displaced = is_left ? pairing_.add_left(entry) : pairing_.add_right(entry);
  if (displaced) ++counters_.dropped_images;
  free(displaced);
  while (const auto stale = pairing_.take_stale()) free(stale);
}

void ImageReceiver::free(std::optional<std::size_t> slot) {
  if (slot) free_slots_[free_count_++] = *slot;
}

void ImageReceiver::provide(const Calibration& calibration) {
  {
    const std::lock_guard lock(mutex_);
    calibration_ = calibration;
    wants_calibration_ = false;
  }
  changed_.notify_all();
}

std::optional<Calibration> ImageReceiver::wait_for_calibration(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait(lock, stop, [&] { return calibration_.has_value(); })) return std::nullopt;
  return calibration_;
}

std::optional<LivePairing::Decision> ImageReceiver::wait_for_pair(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  std::optional<LivePairing::Decision> decision;
  const bool is_there = changed_.wait(lock, stop, [&] {
    decision = pairing_.decide();
    return decision.has_value();
  });
  if (!is_there) return std::nullopt;
  counters_.lost_images += decision->lost;
  return decision;
}

void ImageReceiver::give_back(const LivePairing::Decision& decision) {
  const std::lock_guard lock(mutex_);
  free(decision.left.slot);
  if (decision.right) free(decision.right->slot);
}

ImageReceiver::Counters ImageReceiver::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

bool ImageReceiver::is_ambiguous() const {
  const std::lock_guard lock(mutex_);
  return is_ambiguous_;
}

std::string ImageReceiver::calibration_fault() const {
  const std::lock_guard lock(mutex_);
  return calibration_fault_;
}

}  // namespace egomod
