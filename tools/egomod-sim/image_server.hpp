// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>

#include "egomod/capture/sim_protocol.hpp"
#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"

namespace egomod::sim {

struct ServeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The simulator's end of egomod/capture/sim_protocol.hpp: a ring of images in shared memory, and
// the socket to the daemon. Throws ServeError. Threads: one caller.
class ImageServer {
 public:
  // `pairs` 0: endless.
  ImageServer(int socket, const Calibration& calibration, std::uint64_t pairs);
  ImageServer(const ImageServer&) = delete;
  ImageServer& operator=(const ImageServer&) = delete;
  ~ImageServer();

  enum class Wish {
    kImages,   // the daemon asks for the next ones
    kNothing,  // it has not, and the time is over
    kGone,     // there is no daemon any more
  };
  using Clock = std::chrono::steady_clock;
  // Sleeps until the daemon asks, or until the time given.
  [[nodiscard]] Wish wait(std::optional<Clock::time_point> until);

  struct Truth {
    std::span<const std::uint8_t> pose;
    std::span<const std::uint8_t> objects;
    std::span<const std::uint8_t> odometry;  // none without wheels
  };
  // Where no slot is free the image is left out. Truth goes with left images.
  void send(sim_protocol::Eye eye, std::uint64_t sequence, std::int64_t exposure_us,
            const Image& image, const Truth& truth = {});
  void answer();
  void end(std::uint64_t left_images);

 private:
  void send_hello(const Calibration& calibration, std::uint64_t pairs, int memory);
  // The parts of a packet, one behind the other.
  using Packet = std::array<std::span<const std::uint8_t>, 4>;
  void send(const Packet& packet, int descriptor = -1);

  int socket_;
  std::uint64_t slot_bytes_;
  std::uint8_t* slots_ = nullptr;
  std::uint32_t free_slots_ = (1U << sim_protocol::kSlots) - 1U;
};

}  // namespace egomod::sim
