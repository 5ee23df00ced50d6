// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "egomod/bus/bus_address.hpp"
#include "egomod/publish/encoded_message.hpp"

namespace egomod {

// The LCM bus, which may be absent: what it does not take is counted, never an exception.
// Threads: one caller.
class Bus {
 public:
  // `retry`: a bus that cannot be opened is tried again when there is something to send.
  Bus(BusAddress address, bool retry);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  ~Bus();

  void send(const EncodedMessage& message);

  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  [[nodiscard]] std::uint64_t errors() const { return errors_; }
  // Why the last message did not go out, with the remedy; empty when it did.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  void open();
  [[nodiscard]] bool is_open();

  BusAddress address_;
  bool retry_;
  std::unique_ptr<lcm::LCM> connection_;
  std::uint64_t sent_ = 0;
  std::uint64_t errors_ = 0;
  std::string problem_;
};

}  // namespace egomod
