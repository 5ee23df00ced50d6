// SPDX-License-Identifier: Apache-2.0
#include "capture/sim_link.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

constexpr std::chrono::milliseconds kFarewell{1000};

bool is_interruption(int error) { return error == EINTR || error == EAGAIN; }

}  // namespace

SharedSlots::SharedSlots(const OwnedFd& memory, std::uint64_t slot_bytes)
    : slot_bytes_(slot_bytes) {
  constexpr std::uint64_t kMaxSlotBytes = std::uint64_t{1} << 30U;
  const std::uint64_t bytes = sim_protocol::kSlots * slot_bytes;
  struct stat status {};
  const bool fits = slot_bytes > 0 && slot_bytes <= kMaxSlotBytes &&
                    fstat(memory.get(), &status) == 0 &&
                    static_cast<std::uint64_t>(status.st_size) >= bytes;
  const int seals = fits ? fcntl(memory.get(), F_GET_SEALS) : -1;
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0) {
    SimLink::fail_as_garbage("shared memory that does not hold its images");
  }
  void* const base = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, memory.get(), 0);
  if (base == MAP_FAILED) {
    throw SourceError(std::string("the simulator's memory cannot be mapped: ") +
                      std::strerror(errno));
  }
  base_ = static_cast<const std::uint8_t*>(base);
}

SharedSlots::SharedSlots(SharedSlots&& other) noexcept
    : base_(std::exchange(other.base_, nullptr)), slot_bytes_(other.slot_bytes_) {}

SharedSlots& SharedSlots::operator=(SharedSlots&& other) noexcept {
  std::swap(base_, other.base_);
  std::swap(slot_bytes_, other.slot_bytes_);
  return *this;
}

SharedSlots::~SharedSlots() {
  if (base_ == nullptr) return;
  // munmap takes what mmap gave, which was not const.
  munmap(const_cast<std::uint8_t*>(base_), sim_protocol::kSlots * slot_bytes_);
}

SimLink::SimLink(const std::filesystem::path& program, std::vector<std::string> arguments,
                 std::chrono::milliseconds patience)
    : patience_(patience),
      stopped_(eventfd(0, EFD_CLOEXEC)),
      child_(program, std::move(arguments), sim_protocol::kSocket),
      packet_(std::make_unique<std::uint8_t[]>(sim_protocol::kMaxPacketBytes)) {}

SimLink::Event SimLink::wait(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] { eventfd_write(stopped_.get(), 1); });
  for (;;) {
    std::array<pollfd, 3> fds{{{child_.socket(), POLLIN, 0},
                               {stopped_.get(), POLLIN, 0},
                               {hears_errors_ ? child_.errors() : -1, POLLIN, 0}}};
    const int ready = poll(fds.data(), fds.size(), static_cast<int>(patience_.count()));
    if (ready < 0 && is_interruption(errno)) continue;
    if (stop.stop_requested()) return Event::kStopped;
    if (ready <= 0) {
      throw SourceError("egomod-sim has sent nothing for " +
                        std::to_string(patience_.count() / 1000) + " s");
    }
    if (fds[2].revents != 0) {
      hears_errors_ = child_.read_errors();
      has_news_ = true;
    }
    if (fds[0].revents == 0) continue;
    if (!receive()) fail_as_ended();
    return Event::kPacket;
  }
}

bool SimLink::receive() {
  iovec data{packet_.get(), sim_protocol::kMaxPacketBytes};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  ssize_t size = 0;
  do {
    size = recvmsg(child_.socket(), &message, MSG_CMSG_CLOEXEC);
    // A reset is reported once, ahead of what was sent before it.
  } while (size < 0 && (is_interruption(errno) || errno == ECONNRESET));
  if (size <= 0) return false;
  size_ = static_cast<std::size_t>(size);
  const cmsghdr* const header = CMSG_FIRSTHDR(&message);
  if (header != nullptr && header->cmsg_type == SCM_RIGHTS) {
    int fd = -1;
    std::memcpy(&fd, CMSG_DATA(header), sizeof fd);
    descriptor_ = OwnedFd(fd);
  }
  return true;
}

// A simulator that has hung up may have said why: that is for `wait` to find.
void SimLink::send(const sim_protocol::Request& request) {
  static_cast<void>(::send(child_.socket(), &request, sizeof request, MSG_NOSIGNAL));
}

std::optional<std::string> SimLink::news() {
  if (!std::exchange(has_news_, false)) return std::nullopt;
  return child_.last_words();
}

void SimLink::fail_as_garbage(const std::string& what) {
  throw SourceError("egomod-sim has sent " + what +
                    "; does it come from the same version as this program?");
}

void SimLink::fail_as_ended() {
  const std::string how = child_.end(kFarewell);
  const std::string words = child_.last_words();
  throw SourceError("egomod-sim " + how + (words.empty() ? "" : ": " + words));
}

}  // namespace egomod
