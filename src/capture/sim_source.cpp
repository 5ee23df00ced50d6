// SPDX-License-Identifier: Apache-2.0
#include "capture/sim_source.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <mutex>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "capture/calibration_message.hpp"
#include "capture/live_pairing.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/rig_file.hpp"
#include "capture/sim_link.hpp"
#include "capture/wheel_track.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
namespace protocol = sim_protocol;
using Clock = std::chrono::steady_clock;

constexpr const char* kProgram = "egomod-sim";
constexpr const char* kDefaultWorld = "crossing";
// Long enough to be asked for; what is said once is news once.
constexpr std::chrono::seconds kNoticeStands{2};

std::vector<std::string> arguments_of(const SimSettings& settings) {
  std::vector<std::string> arguments{"--serve", std::to_string(protocol::kSocket)};
  if (settings.realtime) arguments.emplace_back("--realtime");
  if (!settings.lcm_url.empty()) arguments.push_back("--lcm-url=" + settings.lcm_url);
  arguments.emplace_back("--");
  arguments.push_back(settings.world.empty() ? kDefaultWorld : settings.world);
  return arguments;
}

// LCM's types begin with their fingerprint, most significant byte first.
template <typename Message>
void require_type(std::span<const std::uint8_t> bytes) {
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < sizeof fingerprint && i < bytes.size(); ++i) {
    fingerprint = fingerprint << 8U | bytes[i];
  }
  if (fingerprint != static_cast<std::uint64_t>(Message::getHash())) {
    SimLink::fail_as_garbage(std::string("something else as ") + Message::getTypeName());
  }
}

// What waits in a slot, and what came with it.
struct Arrived {
  protocol::Shot shot;
  Nanoseconds arrival{0};
  std::vector<std::uint8_t> truth_pose;
  std::vector<std::uint8_t> truth_objects;
  std::vector<std::uint8_t> odometry;
};

class SimSource final : public FrameSource {
 public:
  SimSource(const SimSettings& settings, const CaptureConfig& config)
      : realtime_(settings.realtime),
        link_(settings.program, arguments_of(settings), settings.patience),
        pairing_(config.max_skew_s),
        rate_(config.max_rate_hz),
        wheels_(config.wheels_max_age_s) {
    static_cast<void>(link_.wait({}));
    const auto hello = link_.read<protocol::Hello>();
    if (hello.kind != protocol::Kind::kHello || hello.version != protocol::kVersion) {
      SimLink::fail_as_garbage("no greeting of version " + std::to_string(protocol::kVersion));
    }
    const auto calibration = decode_calibration(link_.behind<protocol::Hello>());
    if (!calibration) SimLink::fail_as_garbage("no calibration");
    preparer_.emplace(calibration->calibration);
    if (!settings.rig_file.empty()) preparer_->set_calibration(read_rig_file(settings.rig_file));
    slots_ = SharedSlots(link_.descriptor(), hello.slot_bytes);
    size_ = hello.pairs;
  }

  SourceState next(StereoPair& pair, std::stop_token stop) override {
    if (stop.stop_requested()) return SourceState::kStopped;
    if (!error_.empty()) return SourceState::kFailed;
    try {
      return next_or_throw(pair, stop);
    } catch (const SourceError& problem) {
      error_ = problem.what();
      return SourceState::kFailed;
    }
  }

  [[nodiscard]] bool is_replay() const override { return true; }
  [[nodiscard]] bool waits_for_arrival() const override { return true; }
  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] std::string error() const override { return error_; }
  [[nodiscard]] std::string notice() const override {
    const std::lock_guard lock(notice_mutex_);
    return Clock::now() - noticed_ < kNoticeStands ? notice_ : std::string();
  }
  [[nodiscard]] SourceCounters counters() const override {
    return {.lost_images = lost_, .dropped_images = dropped_};
  }
  void set_calibration(const Calibration& calibration) override {
    preparer_->set_calibration(calibration);
  }

 private:
  SourceState next_or_throw(StereoPair& pair, const std::stop_token& stop) {
    if (realtime_) has_asked_ = false;
    for (;;) {
      if (const auto decision = pairing_.decide()) {
        fill(pair, *decision);
        give_back(*decision);
        return SourceState::kPair;
      }
      if (end_) {
        count_missing(std::max(end_->left_images, next_sequence_), 0);
        return SourceState::kEnd;
      }
      if (!has_asked_) ask();
      if (link_.wait(stop) == SimLink::Event::kStopped) return SourceState::kStopped;
      take_packet();
    }
  }

  void ask() {
    link_.send({.free_slots = std::exchange(free_slots_, 0)});
    has_asked_ = true;
    note_news();
  }

  void take_packet() {
    switch (link_.read<protocol::Signal>().kind) {
      case protocol::Kind::kShot:
        return take_shot();
      case protocol::Kind::kAnswered:
        has_asked_ = false;
        return;
      case protocol::Kind::kEnd:
        end_ = link_.read<protocol::End>();
        return pairing_.end();
      default:
        SimLink::fail_as_garbage("a packet of an unknown kind");
    }
  }

  void take_shot() {
    const auto shot = link_.read<protocol::Shot>();
    const bool is_left = shot.eye == protocol::Eye::kLeft;
    require_whole(shot, is_left ? preparer_->left_size() : preparer_->right_size());
    Arrived& arrived = arrived_[shot.slot];
    arrived.shot = shot;
    arrived.arrival = Clock::now().time_since_epoch();
    take_messages(shot, arrived);
    const LivePairing::Entry entry{std::chrono::microseconds(shot.exposure_us), shot.slot};
    const auto displaced = is_left ? pairing_.add_left(entry) : pairing_.add_right(entry);
    free(displaced);
    while (const auto stale = pairing_.take_stale()) free(stale);
  }

  // What lies behind an image.
  void take_messages(const protocol::Shot& shot, Arrived& arrived) {
    const auto bytes = link_.behind<protocol::Shot>();
    const std::size_t truth_bytes = std::size_t{shot.truth_pose_bytes} + shot.truth_objects_bytes;
    if (truth_bytes + shot.odometry_bytes != bytes.size()) {
      SimLink::fail_as_garbage("truth that is not whole");
    }
    const auto pose = bytes.first(shot.truth_pose_bytes);
    const auto objects = bytes.subspan(shot.truth_pose_bytes, shot.truth_objects_bytes);
    const auto odometry = bytes.subspan(truth_bytes);
    if (shot.eye == protocol::Eye::kLeft) {
      require_type<truth_pose_t>(pose);
      require_type<truth_object_list_t>(objects);
    }
    arrived.truth_pose.assign(pose.begin(), pose.end());
    arrived.truth_objects.assign(objects.begin(), objects.end());
    arrived.odometry.assign(odometry.begin(), odometry.end());
    if (odometry.empty()) return;
    const auto reading = decode_odometry(odometry);
    if (!reading) SimLink::fail_as_garbage("something else as odometry_t");
    wheels_.add(*reading);
  }

  void require_whole(const protocol::Shot& shot, ImageSize expected) const {
    const bool has_size = ImageSize{shot.width_px, shot.height_px} == expected;
    const bool fits = shot.slot < protocol::kSlots && shot.stride_bytes >= shot.width_px &&
                      static_cast<std::uint64_t>(shot.stride_bytes) *
                              static_cast<std::uint64_t>(shot.height_px) <=
                          slots_.slot_bytes();
    if (!has_size || !fits) SimLink::fail_as_garbage("an image that cannot be");
  }

  void fill(StereoPair& pair, const LivePairing::Decision& decision) {
    const Arrived& left = arrived_[decision.left.slot];
    preparer_->begin(pair);
    pair.sequence = left.shot.sequence;
    pair.exposure = decision.left.exposure;
    pair.right_exposure = decision.right ? decision.right->exposure : pair.exposure;
    pair.discontinuity = decision.discontinuity;
    pair.arrival = left.arrival;
    pair.wheels = wheels_.at(pair.exposure);
    enclose(left, pair);
    count_missing(left.shot.sequence, decision.lost);
    const bool is_due = rate_.is_due(pair.exposure);
    if (!decision.is_accepted) {
      pair.status = PairStatus::kRejected;
      return;
    }
    const Arrived& right = arrived_[decision.right->slot];
    pair.arrival = std::max(left.arrival, right.arrival);
    if (!is_due) {
      pair.status = PairStatus::kSkipped;
      return;
    }
    copy_image(view(left.shot), preparer_->left_target(pair));
    copy_image(view(right.shot), preparer_->right_target(pair));
    preparer_->finish(pair);
    rate_.keep(pair.exposure);
  }

  // A gap in the numbers is what had no time, or came too late; a gap in the exposures beyond that
  // is what the camera never took.
  void count_missing(std::uint64_t sequence, std::uint64_t gap) {
    if (sequence < next_sequence_) SimLink::fail_as_garbage("images numbered backwards");
    const std::uint64_t dropped = sequence - next_sequence_;
    next_sequence_ = sequence + 1;
    dropped_ += dropped;
    lost_ += gap - std::min(gap, dropped);
  }

  [[nodiscard]] ImageView view(const protocol::Shot& shot) const {
    return {slots_.slot(shot.slot), shot.width_px, shot.height_px, shot.stride_bytes};
  }

  // The simulator itself puts the odometry on the bus.
  static void enclose(const Arrived& left, StereoPair& pair) {
    pair.enclosed.resize(left.odometry.empty() ? 2 : 3);
    pair.enclosed[0].channel = "SIM_TRUTH_POSE";
    pair.enclosed[0].bytes = left.truth_pose;
    pair.enclosed[1].channel = "SIM_TRUTH_OBJECTS";
    pair.enclosed[1].bytes = left.truth_objects;
    if (left.odometry.empty()) return;
    pair.enclosed[2].channel = kOdometryChannel;
    pair.enclosed[2].bytes = left.odometry;
    pair.enclosed[2].is_for_bus = false;
  }

  void give_back(const LivePairing::Decision& decision) {
    free(decision.left.slot);
    if (decision.right) free(decision.right->slot);
  }
  void free(std::optional<std::size_t> slot) {
    if (slot) free_slots_ |= 1U << *slot;
  }

  void note_news() {
    const auto news = link_.news();
    if (!news) return;
    const std::lock_guard lock(notice_mutex_);
    notice_ = *news;
    noticed_ = Clock::now();
  }

  const bool realtime_;
  SimLink link_;
  SharedSlots slots_;
  LivePairing pairing_;
  RateLimiter rate_;
  WheelTrack wheels_;
  std::optional<PairPreparer> preparer_;  // set by the constructor
  std::uint64_t size_ = 0;
  std::array<Arrived, protocol::kSlots> arrived_;
  std::uint32_t free_slots_ = 0;
  bool has_asked_ = false;
  std::optional<protocol::End> end_;
  std::uint64_t next_sequence_ = 0;
  std::string error_;
  std::atomic<std::uint64_t> lost_{0};
  std::atomic<std::uint64_t> dropped_{0};
  mutable std::mutex notice_mutex_;
  std::string notice_;
  Clock::time_point noticed_{};
};

bool is_program(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

}  // namespace

fs::path find_simulator() {
  std::error_code ignored;
  const fs::path here = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::vector<fs::path> folders{here, here.parent_path() / "libexec" / "egomod"};
  const char* const path = std::getenv("PATH");
  std::istringstream rest(path == nullptr ? "" : path);
  for (std::string folder; std::getline(rest, folder, ':');) folders.emplace_back(folder);
  for (const fs::path& folder : folders) {
    if (is_program(folder / kProgram)) return folder / kProgram;
  }
  throw SourceError("source sim: there is no program " + std::string(kProgram) + " in " +
                    folders[0].string() + ", " + folders[1].string() +
                    " or $PATH; install the package egomod-sim, or build it, which needs " +
                    "libegl-dev and libgl-dev");
}

std::unique_ptr<FrameSource> open_sim_source(const SimSettings& settings,
                                             const CaptureConfig& config) {
  try {
    return std::make_unique<SimSource>(settings, config);
  } catch (const std::system_error& problem) {
    throw SourceError(std::string("source sim: egomod-sim cannot be started: ") + problem.what());
  }
}

}  // namespace egomod
