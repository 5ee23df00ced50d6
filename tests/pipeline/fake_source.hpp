// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace egomod {

// Pairs 0, 1, 2, ... every `interval` of stream time; then ends, fails or blocks.
class FakeSource : public FrameSource {
 public:
  struct Settings {
    std::uint64_t pairs = 100;
    SourceState after = SourceState::kEnd;  // kPair: blocks until it is stopped
    bool replay = true;
    bool waits_for_arrival = false;  // a replay that keeps its own pace
    Nanoseconds interval = std::chrono::milliseconds(1);
    std::function<void(StereoPair&)> change = [](StereoPair&) {};  // called for each pair
  };

  explicit FakeSource(Settings settings) : settings_(std::move(settings)) {}

  SourceState next(StereoPair& pair, std::stop_token stop) override {
    if (stop.stop_requested()) {
      return SourceState::kStopped;
    }
    if (next_ == settings_.pairs) {
      return settings_.after == SourceState::kPair ? block(stop) : settings_.after;
    }
    pair.sequence = next_;
    pair.exposure = settings_.interval * static_cast<std::int64_t>(next_);
    pair.right_exposure = pair.exposure;
    pair.status = PairStatus::kOk;
    pair.discontinuity = false;
    settings_.change(pair);
    ++next_;
    return SourceState::kPair;
  }
  bool is_replay() const override { return settings_.replay; }
  bool waits_for_arrival() const override {
    return settings_.waits_for_arrival || !settings_.replay;
  }
  std::string error() const override { return "pair 100: cannot be read"; }
  void set_calibration(const Calibration&) override {}

 private:
  SourceState block(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, stop, [] { return false; });
    return SourceState::kStopped;
  }

  Settings settings_;
  std::uint64_t next_ = 0;
  std::mutex mutex_;
  std::condition_variable_any wake_;
};

}  // namespace egomod
