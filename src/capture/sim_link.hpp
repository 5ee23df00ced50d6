// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/child_process.hpp"
#include "egomod/capture/sim_protocol.hpp"

namespace egomod {

// The memory that the simulator shares, read only. Its size is sealed, so that reading cannot fail.
class SharedSlots {
 public:
  SharedSlots() = default;
  // Throws SourceError if the memory does not hold that many bytes or could shrink.
  SharedSlots(const OwnedFd& memory, std::uint64_t slot_bytes);
  SharedSlots(SharedSlots&& other) noexcept;
  SharedSlots& operator=(SharedSlots&& other) noexcept;
  ~SharedSlots();

  [[nodiscard]] std::uint64_t slot_bytes() const { return slot_bytes_; }
  [[nodiscard]] const std::uint8_t* slot(std::uint32_t index) const {
    return base_ + index * slot_bytes_;
  }

 private:
  const std::uint8_t* base_ = nullptr;
  std::uint64_t slot_bytes_ = 0;
};

// The daemon's end of the line to egomod-sim: packets in and out, and what became of the process.
// Every trouble is a SourceError. Threads: one caller.
class SimLink {
 public:
  enum class Event { kPacket, kStopped };

  SimLink(const std::filesystem::path& program, std::vector<std::string> arguments,
          std::chrono::milliseconds patience);

  // Sleeps until a packet is there or a stop is requested.
  [[nodiscard]] Event wait(const std::stop_token& stop);
  // The packet that has come; untouched until the next wait.
  [[nodiscard]] std::span<const std::uint8_t> packet() const { return {packet_.get(), size_}; }
  // The packet as a struct, and what lies behind it. Throws if it is shorter.
  template <typename Packet>
  [[nodiscard]] Packet read() const;
  template <typename Packet>
  [[nodiscard]] std::span<const std::uint8_t> behind() const {
    return packet().subspan(sizeof(Packet));
  }
  // The descriptor that came with the packet.
  [[nodiscard]] const OwnedFd& descriptor() const { return descriptor_; }

  void send(const sim_protocol::Request& request);
  // What the simulator has said since the last question; nothing if it was silent.
  [[nodiscard]] std::optional<std::string> news();

  [[noreturn]] static void fail_as_garbage(const std::string& what);

 private:
  // False: the simulator has hung up.
  [[nodiscard]] bool receive();
  [[noreturn]] void fail_as_ended();

  std::chrono::milliseconds patience_;
  OwnedFd stopped_;
  ChildProcess child_;
  bool hears_errors_ = true;
  bool has_news_ = false;
  std::unique_ptr<std::uint8_t[]> packet_;
  std::size_t size_ = 0;
  OwnedFd descriptor_;
};

template <typename Packet>
Packet SimLink::read() const {
  if (size_ < sizeof(Packet)) fail_as_garbage("a packet of " + std::to_string(size_) + " bytes");
  Packet result;
  std::memcpy(&result, packet_.get(), sizeof result);
  return result;
}

}  // namespace egomod
