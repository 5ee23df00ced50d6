// SPDX-License-Identifier: Apache-2.0
// Takes the place of egomod-sim in tests: needs no OpenGL, and misbehaves as its world is called.
// A world "NAME@FILE" also writes its process number into the file.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <egomod/calibration_t.hpp>
#include <egomod/odometry_t.hpp>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/messages.hpp"
#include "fake_simulator.hpp"
#include "image_server.hpp"

namespace {

using egomod::Image;
using egomod::sim::ImageServer;
using egomod::sim_protocol::Eye;
using egomod::sim_protocol::Shot;
using namespace egomod::fake_simulator;

template <typename Packet>
void send_raw(const Packet& packet, std::size_t bytes = sizeof(Packet)) {
  if (send(egomod::sim_protocol::kSocket, &packet, bytes, 0) < 0) std::exit(1);
}

Image grey(int value, int width_px = kWidth_px, int height_px = kHeight_px) {
  Image image(width_px, height_px);
  for (int v = 0; v < height_px; ++v) {
    std::memset(image.row(v), value, static_cast<std::size_t>(width_px));
  }
  return image;
}

class Camera {
 public:
  Camera(ImageServer& server, bool has_wheels) : server_(server), has_wheels_(has_wheels) {}

  // Waits until it is asked for.
  void pair(int index, const std::string& world) {
    if (server_.wait(std::nullopt) == ImageServer::Wish::kGone) std::exit(0);
    const bool blinks = world == "blinks" && index == 2;
    const bool winks = world == "winks" && index == 2;
    if (world == "hurries" && index == 2) skipped_ = 3;
    if (world == "counts-backwards" && index == 2) skipped_ = -1;
    if (!blinks) left(index);
    if (!winks) right(index);
    server_.answer();
  }

  void left(int index) {
    pose_.utime = exposure_us(index + std::max(0, skipped_));
    pose_.sequence = taken_++ + skipped_;
    objects_.utime = pose_.utime;
    server_.send(Eye::kLeft, static_cast<std::uint64_t>(pose_.sequence), pose_.utime, grey(index),
                 {egomod::encode_message(pose_, pose_bytes_),
                  egomod::encode_message(objects_, objects_bytes_), odometry()});
  }
  void right(int index) {
    server_.send(Eye::kRight, 0, exposure_us(index + std::max(0, skipped_)) + kSkew_us,
                 grey(100 + index));
  }

  [[nodiscard]] std::uint64_t left_images() const {
    return static_cast<std::uint64_t>(taken_ + std::max(0, skipped_));
  }

 private:
  std::span<const std::uint8_t> odometry() {
    if (!has_wheels_) return {};
    odometry_.utime = pose_.utime;
    odometry_.sequence = pose_.sequence;
    odometry_.x = kWheelStep_m * static_cast<double>(pose_.sequence);
    return egomod::encode_message(odometry_, odometry_bytes_);
  }

  int taken_ = 0;
  int skipped_ = 0;
  ImageServer& server_;
  bool has_wheels_;
  egomod::odometry_t odometry_{};
  std::vector<std::uint8_t> odometry_bytes_;
  egomod::truth_pose_t pose_{};
  egomod::truth_object_list_t objects_{};
  std::vector<std::uint8_t> pose_bytes_;
  std::vector<std::uint8_t> objects_bytes_;
};

// Instead of the third pair.
void misbehave(const std::string& world, ImageServer& server, Camera& camera) {
  if (world == "dies") {
    std::fprintf(stderr, "first it coughs\negomod-sim: the lamp broke\n");
    std::exit(3);
  }
  if (world == "is-killed") std::raise(SIGKILL);
  if (world == "stalls") pause();
  if (world == "hangs-up") {
    close(egomod::sim_protocol::kSocket);
    pause();
  }
  if (world == "unknown-kind") send_raw(static_cast<std::uint32_t>(77));
  if (world == "short-packet") send_raw(Shot{}, 12);
  if (world == "other-size") server.send(Eye::kRight, 0, 0, grey(1, kWidth_px + 1, kHeight_px));
  if (world == "wrong-slot") {
    send_raw(Shot{.eye = Eye::kRight,
                  .slot = 20,
                  .width_px = kWidth_px,
                  .height_px = kHeight_px,
                  .stride_bytes = 64});
  }
  if (world == "no-truth") server.send(Eye::kLeft, 0, 0, grey(1));
  if (world == "half-a-truth") {
    send_raw(Shot{.width_px = kWidth_px,
                  .height_px = kHeight_px,
                  .stride_bytes = 64,
                  .truth_pose_bytes = 1000});
  }
  if (world == "leaves-in-a-hurry") {
    pollfd request{egomod::sim_protocol::kSocket, POLLIN, 0};
    poll(&request, 1, -1);  // stays unread
    camera.left(2);
    camera.right(2);
    server.end(3);
    std::exit(0);
  }
  if (world == "chatters") {
    for (int line = 0; line < 3000; ++line) std::fprintf(stderr, "line %d of nothing much\n", line);
    std::fprintf(stderr, "egomod-sim: no bus\n");
  }
  camera.pair(2, world);
}

// Greetings that are none.
void greet_badly(const std::string& world) {
  if (world == "greets-in-another-version") {
    send_raw(egomod::sim_protocol::Hello{.version = 99});
    pause();
  }
  if (world == "shares-nothing") {
    const egomod::sim_protocol::Hello hello{.slot_bytes = 4096};
    egomod::calibration_t message{};
    std::vector<std::uint8_t> packet(sizeof hello +
                                     static_cast<std::size_t>(message.getEncodedSize()));
    egomod::fill_message(calibration(), true, message);
    std::memcpy(packet.data(), &hello, sizeof hello);
    message.encode(packet.data(), sizeof hello, message.getEncodedSize());
    if (send(egomod::sim_protocol::kSocket, packet.data(), packet.size(), 0) < 0) std::exit(1);
    pause();
  }
  if (world == "cannot-begin") {
    std::fprintf(stderr, "egomod-sim: nowhere: no such world\n");
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string world = argv[argc - 1];
  if (const auto at = world.find('@'); at != std::string::npos) {
    std::ofstream(world.substr(at + 1)) << getpid() << std::flush;
    world.resize(at);
  }
  greet_badly(world);
  ImageServer server(egomod::sim_protocol::kSocket, calibration(), kPairs);
  Camera camera(server, world == "has-wheels");
  for (int pair = 0; pair < kPairs; ++pair) {
    if (pair == 2) {
      misbehave(world, server, camera);
    } else {
      camera.pair(pair, world);
    }
  }
  // One that hurries has no time for the last two either.
  server.end(camera.left_images() + (world == "hurries" ? 2 : 0));
  return 0;
}
