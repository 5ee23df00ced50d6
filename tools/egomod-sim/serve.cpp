// SPDX-License-Identifier: Apache-2.0
#include "serve.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>
#include <optional>
#include <vector>

#include "base_link.hpp"
#include "egomod/publish/encoded_message.hpp"
#include "image_server.hpp"
#include "truth_messages.hpp"

namespace egomod::sim {
namespace {

using sim_protocol::Eye;
using sim_protocol::Kind;

std::uint64_t pairs_of(const World& world) {
  return world.is_endless() ? std::numeric_limits<std::uint64_t>::max()
                            : static_cast<std::uint64_t>(world.pairs());
}

class Session {
 public:
  Session(Simulator& simulator, const ServeOptions& options)
      : simulator_(simulator),
        realtime_(options.realtime),
        server_(options.socket, simulator.calibration(),
                simulator.world().is_endless() ? 0 : pairs_of(simulator.world())) {
    if (simulator.base() != nullptr) link_.emplace(options.lcm_url, *simulator.base());
  }

  void run() {
    const std::uint64_t pairs = pairs_of(simulator_.world());
    for (std::uint64_t pair = 0; pair < pairs; pair = following(pair)) {
      if (!wait_for(pair)) return;
      drive(pair);
      show(pair);
      if (!realtime_) server_.send(Kind::kAnswered);
    }
    server_.send(Kind::kEnd);
  }

 private:
  using Clock = ImageServer::Clock;

  // False: there is nobody to go on for.
  bool wait_for(std::uint64_t pair) {
    if (!realtime_ || !begin_) {
      if (server_.wait(std::nullopt) == ImageServer::Wish::kGone) return false;
      begin_ = begin_.value_or(Clock::now());
      return true;
    }
    const auto due = *begin_ + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(simulator_.time_s(pair)));
    for (;;) {
      const auto wish = server_.wait(due);
      if (wish == ImageServer::Wish::kNothing) return true;
      if (wish == ImageServer::Wish::kGone) return false;
    }
  }

  // By the wall clock the newest that is due, if there are several.
  [[nodiscard]] std::uint64_t following(std::uint64_t pair) const {
    if (!realtime_) return pair + 1;
    const double passed_s = std::chrono::duration<double>(Clock::now() - *begin_).count();
    const auto due = static_cast<std::uint64_t>(passed_s * simulator_.world().rate_hz);
    return std::max(pair + 1, due);
  }

  // Commands that have come until now act from the pair's time on.
  void drive(std::uint64_t pair) {
    if (!link_) return;
    const double now_s = simulator_.time_s(pair);
    simulator_.base()->advance(now_s);
    link_->publish_odometry(now_s);
    link_->take_commands();
  }

  void show(std::uint64_t pair) {
    const double t_s = simulator_.time_s(pair);
    const std::int64_t utime_us = std::llround(1e6 * t_s);
    simulator_.take_pair(pair, left_, right_);
    simulator_.take_truth(pair, truth_);
    if (server_.send(Eye::kLeft, utime_us, left_, truth_at(t_s, utime_us))) ++sequence_;
    server_.send(Eye::kRight, utime_us, right_);
  }

  ImageServer::Truth truth_at(double t_s, std::int64_t utime_us) {
    fill_message(simulator_, t_s, truth_, pose_);
    fill_message(simulator_, t_s, truth_, objects_);
    pose_.utime = utime_us;
    objects_.utime = utime_us;
    pose_.sequence = sequence_;
    objects_.sequence = sequence_;
    return {encode_message(pose_, pose_bytes_), encode_message(objects_, objects_bytes_)};
  }

  Simulator& simulator_;
  const bool realtime_;
  ImageServer server_;
  std::optional<BaseLink> link_;
  std::optional<Clock::time_point> begin_;
  std::int64_t sequence_ = 0;  // of left images that the daemon has got
  Image left_;
  Image right_;
  Truth truth_;
  truth_pose_t pose_{};
  truth_object_list_t objects_{};
  std::vector<std::uint8_t> pose_bytes_;
  std::vector<std::uint8_t> objects_bytes_;
};

}  // namespace

void serve(Simulator& simulator, const ServeOptions& options) {
  // Should the daemon die while a driver hangs in a rendering, nobody would read the socket.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Session(simulator, options).run();
}

}  // namespace egomod::sim
