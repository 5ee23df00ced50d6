// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/publisher.hpp"

#include <chrono>
#include <egomod/health_t.hpp>
#include <mutex>
#include <optional>
#include <utility>

#include "egomod/publish/bus.hpp"
#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/image_encoder.hpp"
#include "egomod/publish/messages.hpp"
#include "egomod/publish/record_writer.hpp"

namespace egomod {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRepetition{1};

struct Channels {
  std::string calibration = "EGOMOD_CALIBRATION";
  std::string pose = "EGOMOD_POSE";
  std::string velocity = "EGOMOD_VELOCITY";
  std::string objects = "EGOMOD_OBJECTS";
  std::string tracks = "EGOMOD_TRACKS";
  std::string images = "EGOMOD_IMAGES";
  std::string timing = "EGOMOD_TIMING";
  std::string health = "EGOMOD_HEALTH";
};

// Bus and record, each perhaps absent. Threads: any.
class Outlet {
 public:
  explicit Outlet(const PublishTarget& target)
      : bus_(target.lcm_url, target.live), live_(target.live) {
    if (!target.record.empty()) record_.emplace(target.record);
    report(bus_.problem());
  }

  void send_to_bus(const EncodedMessage& message) {
    const std::lock_guard lock(mutex_);
    bus_.send(message);
    report(bus_.problem());
  }

  // Into the record.
  void keep(const EncodedMessage& message) {
    const std::lock_guard lock(mutex_);
    if (!record_) return;
    try {
      record_->write(message);
    } catch (const RecordError& error) {
      if (!live_) throw;
      statistics_.record_problem = error.what();
      warnings_.push_back(statistics_.record_problem + "; the record ends here");
      record_.reset();
    }
  }

  // `is_recorded`: into the record too.
  void send(const EncodedMessage& message, bool is_recorded = true) {
    send_to_bus(message);
    if (is_recorded) keep(message);
  }

  // Keeps the message's bytes, to be repeated for whoever listens later.
  void send_to_be_repeated(const EncodedMessage& message) {
    send(message);
    const std::lock_guard lock(mutex_);
    repeated_.assign(message.bytes.begin(), message.bytes.end());
    repeated_utime_us_ = message.utime_us;
    repetition_due_ = SteadyClock::now() + kRepetition;
  }

  void repeat(const std::string& channel) {
    const std::lock_guard lock(mutex_);
    if (repeated_.empty() || SteadyClock::now() < repetition_due_) return;
    bus_.send({channel, repeated_utime_us_, repeated_});
    repetition_due_ += kRepetition;
  }

  void count_not_finite(int messages) {
    const std::lock_guard lock(mutex_);
    statistics_.not_finite += static_cast<std::uint64_t>(messages);
  }

  void close() {
    const std::lock_guard lock(mutex_);
    if (record_) record_->flush();
    if (!statistics_.record_problem.empty()) throw RecordError(statistics_.record_problem);
  }

  PublishStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    PublishStatistics result = statistics_;
    result.sent = bus_.sent();
    result.bus_errors = bus_.errors();
    result.bus_problem = bus_.problem();
    return result;
  }

  std::vector<std::string> take_warnings() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
  }

 private:
  // A replay says it once; live, each change is news.
  void report(const std::string& problem) {
    if (problem == reported_ || (!live_ && !reported_.empty())) return;
    warnings_.push_back(problem.empty() ? "the LCM bus takes messages again" : problem);
    reported_ = problem;
  }

  mutable std::mutex mutex_;
  Bus bus_;
  std::optional<RecordWriter> record_;
  const bool live_;
  std::string reported_;
  std::vector<std::string> warnings_;
  PublishStatistics statistics_;
  std::vector<std::uint8_t> repeated_;
  std::int64_t repeated_utime_us_ = 0;
  SteadyClock::time_point repetition_due_{};
};

}  // namespace

struct Publisher::State {
  State(const PublishConfig& publish_config, const PublishTarget& publish_target)
      : config(publish_config),
        target(publish_target),
        encoder(publish_config.images, publish_config.jpeg_quality),
        outlet(publish_target) {}

  template <typename Message>
  void send(const std::string& channel, const Message& message) {
    outlet.send({channel, message.utime, encode_message(message, buffer)});
  }

  template <typename Message>
  void send_if_finite(const std::string& channel, const Message& message) {
    if (is_finite(message)) {
      send(channel, message);
    } else {
      outlet.count_not_finite(1);
    }
  }

  void send_calibration(const StereoPair& pair);
  void send_objects(const Frame& frame);
  void send_tracks(const Frame& frame);
  void send_images(const StereoPair& pair);
  void send_timing(const Frame& frame);
  void add_image(const Image& image, std::int16_t type, std::int64_t utime_us);

  const PublishConfig config;
  const PublishTarget target;
  const Channels channels{};
  ImageEncoder encoder;
  Outlet outlet;
  std::vector<std::uint8_t> buffer;
  std::optional<Calibration> calibration_sent;
  calibration_t calibration{};
  pose_t pose{};
  velocity_t velocity{};
  object_list_t objects{};
  track_list_t tracks{};
  bot_core::images_t images{};
  timing_t timing{};
};

// Images that are published beside it are rectified; without them it speaks of the source's, so
// that a log of the source's images and of what the daemon says does not contradict itself.
void Publisher::State::send_calibration(const StereoPair& pair) {
  if (calibration_sent && *calibration_sent == pair.calibration) return;
  const bool are_raw = pair.calibration.images_are_raw && config.images == ImageEncoding::kNone;
  fill_message(pair.calibration, are_raw, calibration);
  calibration.utime = pair.utime_us();
  calibration.sequence = static_cast<std::int64_t>(pair.sequence);
  calibration_sent = pair.calibration;
  if (!is_finite(calibration)) {
    outlet.count_not_finite(1);
    return;
  }
  outlet.send_to_be_repeated(
      {channels.calibration, calibration.utime, encode_message(calibration, buffer)});
}

void Publisher::State::send_objects(const Frame& frame) {
  if (!frame.objects.has_run) return;
  outlet.count_not_finite(fill_message(frame, objects));
  send(channels.objects, objects);
}

void Publisher::State::send_tracks(const Frame& frame) {
  if (!config.tracks || frame.pair.status != PairStatus::kOk) return;
  outlet.count_not_finite(fill_message(frame, tracks));
  send(channels.tracks, tracks);
}

void Publisher::State::add_image(const Image& image, std::int16_t type, std::int64_t utime_us) {
  if (image.empty()) return;
  const auto count = static_cast<std::size_t>(images.n_images);
  if (images.images.size() <= count) images.images.resize(count + 1);
  encoder.encode(image.view(), utime_us, images.images[count]);
  images.image_types.push_back(type);
  ++images.n_images;
}

void Publisher::State::send_images(const StereoPair& pair) {
  if (config.images == ImageEncoding::kNone || pair.left.empty()) return;
  const std::int64_t skew_us =
      std::chrono::duration_cast<std::chrono::microseconds>(pair.skew()).count();
  images.utime = pair.utime_us();
  images.n_images = 0;
  images.image_types.clear();
  add_image(pair.left, bot_core::images_t::LEFT, images.utime);
  add_image(pair.right, bot_core::images_t::RIGHT, images.utime + skew_us);
  send(channels.images, images);
}

void Publisher::State::send_timing(const Frame& frame) {
  fill_message(frame, SteadyClock::now().time_since_epoch(), timing);
  outlet.send({channels.timing, timing.utime, encode_message(timing, buffer)},
              target.record_timing);
}

Publisher::Publisher(const PublishConfig& config, const PublishTarget& target)
    : state_(std::make_unique<State>(config, target)) {}

Publisher::~Publisher() = default;

void Publisher::publish(const Frame& frame) {
  State& state = *state_;
  state.send_calibration(frame.pair);
  fill_message(frame, state.pose);
  state.send_if_finite(state.channels.pose, state.pose);
  fill_message(frame, state.velocity);
  state.send_if_finite(state.channels.velocity, state.velocity);
  state.send_objects(frame);
  state.send_tracks(frame);
  state.send_images(frame.pair);
  if (state.target.live || state.target.record_timing) state.send_timing(frame);
  for (const EnclosedMessage& message : frame.pair.enclosed) {
    const EncodedMessage encoded{message.channel, frame.pair.utime_us(), message.bytes};
    if (message.is_for_bus) state.outlet.send_to_bus(encoded);
    state.outlet.keep(encoded);
  }
}

void Publisher::publish_health(const health_t& message) {
  std::vector<std::uint8_t> buffer;  // of its own: another thread's than publish
  state_->outlet.send_to_bus(
      {state_->channels.health, message.utime, encode_message(message, buffer)});
}

void Publisher::repeat_calibration() { state_->outlet.repeat(state_->channels.calibration); }

void Publisher::close() { state_->outlet.close(); }

PublishStatistics Publisher::statistics() const { return state_->outlet.statistics(); }

std::vector<std::string> Publisher::take_warnings() { return state_->outlet.take_warnings(); }

}  // namespace egomod
