// SPDX-License-Identifier: Apache-2.0
#include "serve.hpp"

#include <sys/prctl.h>

#include <cmath>
#include <csignal>
#include <optional>
#include <vector>

#include "base_link.hpp"
#include "deliveries.hpp"
#include "egomod/publish/encoded_message.hpp"
#include "image_server.hpp"
#include "truth_messages.hpp"

namespace egomod::sim {
namespace {

namespace protocol = sim_protocol;

// Simulated time, as in times.txt of a rendered folder.
std::int64_t utime_us(const Exposure& exposure) { return std::llround(1e6 * exposure.t_s); }

class Session {
 public:
  Session(Simulator& simulator, const ServeOptions& options)
      : simulator_(simulator),
        realtime_(options.realtime),
        calibration_(simulator.calibration()),
        server_(options.socket, calibration_, pairs_of(simulator.world())),
        deliveries_(simulator.world()) {
    if (simulator.base() != nullptr) link_.emplace(options.lcm_url, *simulator.base());
  }

  void run() {
    while (const auto delivery = deliveries_.next()) {
      left_images_ += delivery->eye == Eye::kLeft ? 1 : 0;
      if (is_out_of_date(*delivery)) continue;
      if (!wait_for(*delivery)) return;
      drive(delivery->exposure.t_s);
      show(*delivery);
      if (!realtime_) server_.answer();
    }
    server_.end(left_images_);
  }

 private:
  using Clock = ImageServer::Clock;

  static std::uint64_t pairs_of(const World& world) {
    return world.is_endless() ? 0 : static_cast<std::uint64_t>(world.pairs());
  }

  [[nodiscard]] Clock::time_point due(double t_s) const {
    return *begin_ +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(t_s));
  }

  // By the wall clock, when the camera's next image has arrived meanwhile.
  [[nodiscard]] bool is_out_of_date(const Delivery& delivery) const {
    const double next_s = delivery.arrival_s() + 1.0 / simulator_.world().rate_hz;
    return realtime_ && begin_ && Clock::now() >= due(next_s);
  }

  // False: there is nobody to go on for.
  bool wait_for(const Delivery& delivery) {
    if (!realtime_ || !begin_) {
      if (server_.wait(std::nullopt) == ImageServer::Wish::kGone) return false;
      begin_ = begin_.value_or(Clock::now());
      return true;
    }
    for (;;) {
      const auto wish = server_.wait(due(delivery.arrival_s()));
      if (wish == ImageServer::Wish::kNothing) return true;
      if (wish == ImageServer::Wish::kGone) return false;
    }
  }

  // Commands that have come until now act from the exposure's time on.
  void drive(double t_s) {
    if (!link_) return;
    simulator_.base()->advance(t_s);
    link_->publish_odometry(t_s);
    link_->take_commands();
  }

  void show(const Delivery& delivery) {
    const std::uint64_t number = delivery.exposure.number;
    if (delivery.is_pair) {
      simulator_.take_pair(number, left_, right_);
    } else {
      simulator_.take_image(delivery.eye, number, delivery.eye == Eye::kLeft ? left_ : right_);
    }
    if (delivery.eye == Eye::kLeft) send_left(delivery);
    if (delivery.eye == Eye::kRight || delivery.is_pair) {
      server_.send(protocol::Eye::kRight, delivery.index, utime_us(delivery.exposure), right_);
    }
  }

  void send_left(const Delivery& delivery) {
    simulator_.take_truth(delivery.exposure.number, truth_);
    const std::int64_t utime = utime_us(delivery.exposure);
    const auto sequence = static_cast<std::int64_t>(delivery.index);
    fill_message(truth_, calibration_.T_body_camera, utime, sequence, pose_);
    fill_message(truth_, calibration_.T_body_camera, utime, sequence, objects_);
    encode_odometry(delivery.exposure.t_s, sequence);
    server_.send(protocol::Eye::kLeft, delivery.index, utime, left_,
                 {encode_message(pose_, pose_bytes_), encode_message(objects_, objects_bytes_),
                  odometry_bytes_});
  }

  // At the exposure itself, so that it depends on no rate.
  void encode_odometry(double t_s, std::int64_t sequence) {
    if (simulator_.base() == nullptr) return;
    odometry_ = odometry(simulator_.base()->at(t_s), t_s, sequence);
    static_cast<void>(encode_message(odometry_, odometry_bytes_));
  }

  Simulator& simulator_;
  const bool realtime_;
  const Calibration calibration_;
  ImageServer server_;
  Deliveries deliveries_;
  std::optional<BaseLink> link_;
  std::optional<Clock::time_point> begin_;
  std::uint64_t left_images_ = 0;
  Image left_;
  Image right_;
  Truth truth_;
  truth_pose_t pose_{};
  truth_object_list_t objects_{};
  odometry_t odometry_{};
  std::vector<std::uint8_t> pose_bytes_;
  std::vector<std::uint8_t> objects_bytes_;
  std::vector<std::uint8_t> odometry_bytes_;
};

}  // namespace

void serve(Simulator& simulator, const ServeOptions& options) {
  // Should the daemon die while a driver hangs in a rendering, nobody would read the socket.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Session(simulator, options).run();
}

}  // namespace egomod::sim
