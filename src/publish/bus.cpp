// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/bus.hpp"

#include <lcm/lcm-cpp.hpp>
#include <utility>

namespace egomod {
namespace {

std::string shown(const std::string& url) { return url.empty() ? "the default" : url; }

}  // namespace

Bus::Bus(BusAddress address, bool retry) : address_(std::move(address)), retry_(retry) { open(); }

Bus::~Bus() = default;

void Bus::open() {
  connection_ = address_.open();
  if (connection_) return;
  problem_ =
      "the LCM bus (URL: " + shown(address_.url()) + ") cannot be opened; " + address_.remedy();
}

bool Bus::is_open() {
  if (!connection_ && retry_) open();
  return connection_ != nullptr;
}

void Bus::send(const EncodedMessage& message) {
  if (!is_open()) {
    ++errors_;
    return;
  }
  const auto size = static_cast<unsigned int>(message.bytes.size());
  if (connection_->publish(message.channel, message.bytes.data(), size) == 0) {
    ++sent_;
    problem_.clear();
    return;
  }
  ++errors_;
  problem_ = "the LCM bus (URL: " + shown(address_.url()) +
             ") takes no messages; see whether the network it was opened on is still there";
}

}  // namespace egomod
