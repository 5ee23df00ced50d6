// SPDX-License-Identifier: Apache-2.0
#include "capture/lcm_source.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "capture/image_decoder.hpp"
#include "capture/image_receiver.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/receive_buffer.hpp"
#include "capture/rig_file.hpp"
#include "capture/sources.hpp"
#include "capture/wheel_track.hpp"

namespace egomod {
namespace {

constexpr int kHandleTimeout_ms = 50;
constexpr std::chrono::seconds kRetry{1};
constexpr std::chrono::seconds kFirstImagesWithin{3};

class LcmSource final : public FrameSource {
 public:
  // `bus`, if it is given, is used instead of the one at `address`.
  LcmSource(lcm::LCM* bus, BusAddress address, const CaptureConfig& config,
            std::optional<Calibration> calibration)
      : address_(std::move(address)),
        url_(with_receive_buffer(address_.url())),
        receive_buffer_(granted_bytes(url_, allowed_receive_buffer_bytes())),
        receiver_(config, !calibration),
        rate_(config.max_rate_hz),
        wheels_(config.wheels_max_age_s),
        bus_(bus) {
    if (calibration) prepare(*calibration);
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
      prepare(calibration);
      receiver_.provide(calibration);
    }
  }

  // That there is no bus says the publisher, which wants the same one.
  [[nodiscard]] std::string notice() const override {
    const std::lock_guard lock(mutex_);
    if (!bus_notice_.empty() || preparer_ || !is_connected_) return bus_notice_;
    const std::string fault = receiver_.calibration_fault();
    return std::string("waiting for ") + kCalibrationChannel + " on the bus" +
           (fault.empty() ? "" : " (what came cannot be right: " + fault + ")") +
           ": publish it, or name a rig file with --rig";
  }

  [[nodiscard]] std::vector<std::string> take_warnings() override {
    const std::lock_guard lock(mutex_);
    const auto received = receiver_.counters();
    std::vector<std::string> warnings;
    if (receiver_.is_ambiguous() && !std::exchange(has_warned_of_ambiguity_, true)) {
      warnings.push_back("a message on " + receiver_.channels().both + " " + kAmbiguousImages +
                         "; such messages are left out");
    }
    std::string warning =
        receive_buffer_.warning({.largest_message_bytes = received.largest_message_bytes,
                                 .awaited_bytes = awaited_bytes(),
                                 .lost_images = received.lost_images});
    if (!warning.empty()) warnings.push_back(std::move(warning));
    return warnings;
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
    if (!preparer_) prepare(*calibration);
    return true;
  }

  void prepare(const Calibration& calibration) {
    preparer_ = std::make_unique<PairPreparer>(calibration);
    prepared_at_ = std::chrono::steady_clock::now();
  }

  // Of a raw pair, which should have come by now; 0 if it need not.
  [[nodiscard]] std::size_t awaited_bytes() const {
    const bool is_overdue = preparer_ && is_connected_ &&
                            std::chrono::steady_clock::now() - prepared_at_ > kFirstImagesWithin;
    if (!is_overdue) return 0;
    const ImageSize size = preparer_->left_size();
    const bool is_both = !receiver_.channels().both.empty();
    return (is_both ? std::size_t{2} : std::size_t{1}) * static_cast<std::size_t>(size.width_px) *
           static_cast<std::size_t>(size.height_px);
  }

  void fill(StereoPair& pair, const LivePairing::Decision& decision) {
    const ImageReceiver::Slot& left = receiver_.slot(decision.left.slot);
    preparer_->begin(pair);
    pair.sequence = sequence_++;
    pair.exposure = decision.left.exposure;
    pair.right_exposure = decision.nearest_right.value_or(pair.exposure);
    pair.discontinuity = decision.discontinuity;
    pair.arrival = left.arrival;
    pair.wheels = wheels_at(pair.exposure);
    const bool is_due = rate_.is_due(pair.exposure);
    if (!decision.is_accepted) {
      PairPreparer::reject(pair, decision.nearest_right ? PairFault::kSkew : PairFault::kNoPartner);
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

  [[nodiscard]] std::optional<WheelPose> wheels_at(Nanoseconds exposure) const {
    const std::lock_guard lock(wheels_mutex_);
    return wheels_.at(exposure);
  }

  static void on_message(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                         LcmSource* self) {
    self->receiver_.receive(channel,
                            {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  }

  static void on_odometry(const lcm::ReceiveBuffer* buffer, const std::string& /*channel*/,
                          LcmSource* self) {
    const auto reading =
        decode_odometry({static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
    if (!reading) return;
    const std::lock_guard lock(self->wheels_mutex_);
    self->wheels_.add(*reading);
  }

  void subscribe() {
    const ImageChannels& channels = receiver_.channels();
    for (const std::string& channel :
         {channels.both, channels.left, channels.right, std::string(kCalibrationChannel)}) {
      if (channel.empty()) continue;
      subscriptions_.push_back(bus_->subscribeFunction(channel, &LcmSource::on_message, this));
    }
    subscriptions_.push_back(
        bus_->subscribeFunction(kOdometryChannel, &LcmSource::on_odometry, this));
    const std::lock_guard lock(mutex_);
    is_connected_ = true;
  }

  void set_bus_notice(const std::string& text) {
    const std::lock_guard lock(mutex_);
    bus_notice_ = text;
  }

  // A network that is not up yet comes up later.
  void connect(const std::stop_token& stop) {
    while (bus_ == nullptr && !stop.stop_requested()) {
      own_bus_ = address_.open(url_);
      bus_ = own_bus_.get();
      if (bus_ != nullptr) {
        subscribe();
        return;
      }
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

  const BusAddress address_;
  const std::string url_;
  ReceiveBufferWatch receive_buffer_;  // under the mutex
  ImageReceiver receiver_;
  RateLimiter rate_;
  ImageDecoder decoder_;
  mutable std::mutex wheels_mutex_;
  WheelTrack wheels_;
  std::uint64_t sequence_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable_any retry_;
  std::string bus_notice_;
  bool is_connected_ = false;
  bool has_warned_of_ambiguity_ = false;
  std::chrono::steady_clock::time_point prepared_at_{};
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

std::unique_ptr<FrameSource> open_lcm_source(lcm::LCM& bus, const CaptureConfig& config,
                                             const std::string& rig_file) {
  return std::make_unique<LcmSource>(&bus, BusAddress(), config, rig_calibration(rig_file));
}

std::unique_ptr<FrameSource> open_lcm_source(const BusAddress& address, const CaptureConfig& config,
                                             const std::string& rig_file) {
  return std::make_unique<LcmSource>(nullptr, address, config, rig_calibration(rig_file));
}

}  // namespace egomod
