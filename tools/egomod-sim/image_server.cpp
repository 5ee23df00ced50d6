// SPDX-License-Identifier: Apache-2.0
#include "image_server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <egomod/calibration_t.hpp>

#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/messages.hpp"

namespace egomod::sim {
namespace {

namespace protocol = sim_protocol;

[[noreturn]] void fail(const char* what) {
  throw ServeError(fmt::format("{}: {}", what, std::strerror(errno)));
}

std::size_t image_bytes(int width_px, int height_px) {
  const Image image(width_px, height_px);
  return static_cast<std::size_t>(image.stride_bytes()) * static_cast<std::size_t>(height_px);
}

std::size_t largest_image_bytes(const Calibration& c) {
  if (!c.images_are_raw) return image_bytes(c.camera.width_px, c.camera.height_px);
  return std::max(image_bytes(c.left.width_px, c.left.height_px),
                  image_bytes(c.right.width_px, c.right.height_px));
}

template <typename Packet>
std::span<const std::uint8_t> bytes_of(const Packet& packet) {
  return {reinterpret_cast<const std::uint8_t*>(&packet), sizeof packet};
}

}  // namespace

ImageServer::ImageServer(int socket, const Calibration& calibration, std::uint64_t pairs)
    : socket_(socket), slot_bytes_(largest_image_bytes(calibration)) {
  const std::size_t bytes = protocol::kSlots * slot_bytes_;
  const int memory = memfd_create("egomod-sim", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory < 0 || ftruncate(memory, static_cast<off_t>(bytes)) != 0) fail("no shared memory");
  void* const base = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
  if (base == MAP_FAILED) fail("the shared memory cannot be mapped");
  slots_ = static_cast<std::uint8_t*>(base);
  fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL);
  send_hello(calibration, pairs, memory);
  close(memory);
}

ImageServer::~ImageServer() { munmap(slots_, protocol::kSlots * slot_bytes_); }

void ImageServer::send_hello(const Calibration& calibration, std::uint64_t pairs, int memory) {
  calibration_t message{};
  fill_message(calibration, calibration.images_are_raw, message);
  std::vector<std::uint8_t> buffer;
  const protocol::Hello hello{.pairs = pairs, .slot_bytes = slot_bytes_};
  send({bytes_of(hello), encode_message(message, buffer), {}, {}}, memory);
}

void ImageServer::send(const Packet& packet, int descriptor) {
  std::array<iovec, 4> parts{};
  std::ranges::transform(packet, parts.begin(), [](std::span<const std::uint8_t> part) {
    return iovec{const_cast<std::uint8_t*>(part.data()), part.size()};  // it is only read
  });
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  if (descriptor >= 0) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  }
  if (sendmsg(socket_, &message, MSG_NOSIGNAL) < 0) fail("the daemon does not listen");
}

ImageServer::Wish ImageServer::wait(std::optional<Clock::time_point> until) {
  pollfd socket{socket_, POLLIN, 0};
  int timeout_ms = -1;
  if (until) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*until - Clock::now());
    timeout_ms = static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1 << 30));
  }
  if (poll(&socket, 1, timeout_ms) <= 0) return Wish::kNothing;
  protocol::Request request;
  if (recv(socket_, &request, sizeof request, 0) != sizeof request) return Wish::kGone;
  free_slots_ |= request.free_slots;
  return Wish::kImages;
}

void ImageServer::send(protocol::Eye eye, std::uint64_t sequence, std::int64_t exposure_us,
                       const Image& image, const Truth& truth) {
  if (free_slots_ == 0) return;
  const auto slot = static_cast<std::uint32_t>(std::countr_zero(free_slots_));
  free_slots_ &= free_slots_ - 1U;
  const auto bytes = static_cast<std::size_t>(image.stride_bytes() * image.height_px());
  std::memcpy(slots_ + slot * slot_bytes_, image.row(0), bytes);
  const protocol::Shot shot{.eye = eye,
                            .slot = slot,
                            .width_px = image.width_px(),
                            .height_px = image.height_px(),
                            .stride_bytes = static_cast<std::int32_t>(image.stride_bytes()),
                            .exposure_us = exposure_us,
                            .sequence = sequence,
                            .truth_pose_bytes = static_cast<std::uint32_t>(truth.pose.size()),
                            .truth_objects_bytes = static_cast<std::uint32_t>(truth.objects.size()),
                            .odometry_bytes = static_cast<std::uint32_t>(truth.odometry.size())};
  send({bytes_of(shot), truth.pose, truth.objects, truth.odometry});
}

void ImageServer::answer() {
  const protocol::Signal answered{.kind = protocol::Kind::kAnswered};
  send({bytes_of(answered), {}, {}, {}});
}

void ImageServer::end(std::uint64_t left_images) {
  const protocol::End end{.left_images = left_images};
  send({bytes_of(end), {}, {}, {}});
}

}  // namespace egomod::sim
