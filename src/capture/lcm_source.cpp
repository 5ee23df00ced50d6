// SPDX-License-Identifier: Apache-2.0
#include "capture/lcm_source.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "capture/image_decoder.hpp"
#include "capture/image_receiver.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/rig_file.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr long kReceiveBufferBytes = 8L << 20;
constexpr int kHandleTimeout_ms = 50;
constexpr std::chrono::seconds kRetry{1};

// What the kernel grants of the wanted receive buffer; empty if all of it.
std::string receive_buffer_notice() {
  long granted_bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> granted_bytes;
  if (granted_bytes == 0 || granted_bytes >= kReceiveBufferBytes) return {};
  return "the kernel caps receive buffers at " + std::to_string(granted_bytes) +
         " bytes: large images get lost; run 'sysctl -w net.core.rmem_max=" +
         std::to_string(kReceiveBufferBytes) + "'";
}

class LcmSource final : public FrameSource {
 public:
  // One of `bus` and `url` is used.
  LcmSource(lcm::LCM* bus, std::string url, const CaptureConfig& config,
            std::optional<Calibration> calibration)
      : url_(std::move(url)),
        receiver_(config, !calibration),
        rate_(config.max_rate_hz),
        bus_(bus) {
    if (calibration) preparer_ = std::make_unique<PairPreparer>(*calibration);
    if (bus_ != nullptr) subscribe();
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  ~LcmSource() override {
    thread_.request_stop();
    thread_.join();
    for (lcm::Subscription* subscription : subscriptions_) bus_->unsubscribe(subscription);
  }

  SourceState next(StereoPair& pair, std::stop_token stop) override {
    if (!has_preparer() && !wait_for_calibration(stop)) return SourceState::kStopped;
    const auto decision = receiver_.wait_for_pair(stop);
    if (!decision) return SourceState::kStopped;
    fill(pair, *decision);
    receiver_.give_back(*decision);
    return SourceState::kPair;
  }

  [[nodiscard]] bool is_replay() const override { return false; }

  void set_calibration(const Calibration& calibration) override {
    const std::lock_guard lock(mutex_);
    if (preparer_) {
      preparer_->set_calibration(calibration);
    } else {
      preparer_ = std::make_unique<PairPreparer>(calibration);
      receiver_.provide(calibration);
    }
  }

  [[nodiscard]] std::string notice() const override {
    const std::lock_guard lock(mutex_);
    std::string text = bus_notice_;
    if (!preparer_) {
      text += (text.empty() ? "" : "; ") + std::string("waiting for ") + kCalibrationChannel +
              " on the bus: publish it, or name a rig file with --rig";
    }
    return text;
  }

  [[nodiscard]] SourceCounters counters() const override {
    const auto received = receiver_.counters();
    return {.lost_images = received.lost_images,
            .dropped_images = received.dropped_images,
            .damaged_messages = received.damaged_messages};
  }

 private:
  [[nodiscard]] bool has_preparer() const {
    const std::lock_guard lock(mutex_);
    return preparer_ != nullptr;
  }

  bool wait_for_calibration(const std::stop_token& stop) {
    const auto calibration = receiver_.wait_for_calibration(stop);
    if (!calibration) return false;
    const std::lock_guard lock(mutex_);
    if (!preparer_) preparer_ = std::make_unique<PairPreparer>(*calibration);
    return true;
  }

  void fill(StereoPair& pair, const LivePairing::Decision& decision) {
    const ImageReceiver::Slot& left = receiver_.slot(decision.left.slot);
    preparer_->begin(pair);
    pair.sequence = sequence_++;
    pair.exposure = decision.left.exposure;
    pair.right_exposure = decision.right ? decision.right->exposure : pair.exposure;
    pair.discontinuity = decision.discontinuity;
    pair.arrival = left.arrival;
    const bool is_due = rate_.is_due(pair.exposure);
    if (!decision.is_accepted) {
      pair.status = PairStatus::kRejected;
      return;
    }
    const ImageReceiver::Slot& right = receiver_.slot(decision.right->slot);
    pair.arrival = std::max(left.arrival, right.arrival);
    if (!is_due) {
      pair.status = PairStatus::kSkipped;
    } else if (decoder_.decode(left.record, left.bytes, preparer_->left_size(),
                               preparer_->left_target(pair)) &&
               decoder_.decode(right.record, right.bytes, preparer_->right_size(),
                               preparer_->right_target(pair))) {
      preparer_->finish(pair);
      rate_.keep(pair.exposure);
    } else {
      PairPreparer::reject(pair);
    }
  }

  static void on_message(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                         LcmSource* self) {
    self->receiver_.receive(channel,
                            {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  }

  void subscribe() {
    const ImageChannels& channels = receiver_.channels();
    for (const std::string& channel :
         {channels.both, channels.left, channels.right, std::string(kCalibrationChannel)}) {
      if (channel.empty()) continue;
      subscriptions_.push_back(bus_->subscribeFunction(channel, &LcmSource::on_message, this));
    }
  }

  void set_bus_notice(const std::string& text) {
    const std::lock_guard lock(mutex_);
    bus_notice_ = text;
  }

  // A network that is not up yet comes up later: asked again each second.
  void connect(const std::stop_token& stop) {
    while (bus_ == nullptr && !stop.stop_requested()) {
      auto bus = std::make_unique<lcm::LCM>(url_);
      if (bus->good()) {
        own_bus_ = std::move(bus);
        bus_ = own_bus_.get();
        set_bus_notice(url_.starts_with("udpm://") ? receive_buffer_notice() : "");
        subscribe();
        return;
      }
      set_bus_notice("the bus " + url_ +
                     " cannot be opened; is there a multicast route ('ip route " +
                     "add 224.0.0.0/4 dev lo')? Trying again");
      std::unique_lock lock(mutex_);
      retry_.wait_for(lock, stop, kRetry, [] { return false; });
    }
  }

  void run(const std::stop_token& stop) {
    connect(stop);
    while (!stop.stop_requested()) {
      if (bus_->handleTimeout(kHandleTimeout_ms) >= 0) continue;
      set_bus_notice("receiving from the bus " + url_ + " failed");
      std::unique_lock lock(mutex_);
      retry_.wait_for(lock, stop, kRetry, [] { return false; });
    }
  }

  const std::string url_;
  ImageReceiver receiver_;
  RateLimiter rate_;
  ImageDecoder decoder_;
  std::uint64_t sequence_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable_any retry_;
  std::string bus_notice_;
  std::unique_ptr<PairPreparer> preparer_;  // set once, under the mutex
  std::unique_ptr<lcm::LCM> own_bus_;
  lcm::LCM* bus_;
  std::vector<lcm::Subscription*> subscriptions_;
  std::jthread thread_;  // last: it ends before what it uses
};

std::optional<Calibration> rig_calibration(const std::string& rig_file) {
  if (rig_file.empty()) return std::nullopt;
  return read_rig_file(rig_file);
}

}  // namespace

std::string with_receive_buffer(const std::string& given) {
  std::string url = given;
  if (const char* preset = std::getenv("LCM_DEFAULT_URL"); url.empty() && preset != nullptr) {
    url = preset;
  }
  if (url.empty()) url = kDefaultUrl;
  const bool is_set = url.find("recv_buf_size=") != std::string::npos;
  if (!url.starts_with("udpm://") || is_set) return url;
  const char join = url.find('?') == std::string::npos ? '?' : '&';
  return url + join + "recv_buf_size=" + std::to_string(kReceiveBufferBytes);
}

std::unique_ptr<FrameSource> open_lcm_source(lcm::LCM& bus, const CaptureConfig& config,
                                             const std::string& rig_file) {
  return std::make_unique<LcmSource>(&bus, "", config, rig_calibration(rig_file));
}

std::unique_ptr<FrameSource> open_lcm_source(const std::string& url, const CaptureConfig& config,
                                             const std::string& rig_file) {
  return std::make_unique<LcmSource>(nullptr, with_receive_buffer(url), config,
                                     rig_calibration(rig_file));
}

}  // namespace egomod
