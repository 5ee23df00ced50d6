// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/bus.hpp"

#include <lcm/lcm-cpp.hpp>
#include <utility>

namespace egomod {
namespace {

constexpr std::chrono::seconds kRetryInterval{2};

std::string shown(const std::string& url) { return url.empty() ? "the default" : url; }

}  // namespace

struct Bus::Connection {
  explicit Connection(const std::string& url) : lcm(url) {}
  lcm::LCM lcm;
};

Bus::Bus(std::string url, bool retry) : url_(std::move(url)), retry_(retry) { open(); }

Bus::~Bus() = default;

void Bus::open() {
  tried_ = std::chrono::steady_clock::now();
  connection_ = std::make_unique<Connection>(url_);
  if (connection_->lcm.good()) return;
  connection_.reset();
  problem_ = "the LCM bus (URL: " + shown(url_) +
             ") cannot be opened; UDP multicast needs a route, and without a network this gives " +
             "one: ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo";
}

bool Bus::is_open() {
  if (!connection_ && retry_ && std::chrono::steady_clock::now() - tried_ >= kRetryInterval) {
    open();
  }
  return connection_ != nullptr;
}

void Bus::send(const EncodedMessage& message) {
  if (!is_open()) {
    ++errors_;
    return;
  }
  const auto size = static_cast<unsigned int>(message.bytes.size());
  if (connection_->lcm.publish(message.channel, message.bytes.data(), size) == 0) {
    ++sent_;
    problem_.clear();
    return;
  }
  ++errors_;
  problem_ = "the LCM bus (URL: " + shown(url_) +
             ") takes no messages; see whether the network it was opened on is still there";
}

}  // namespace egomod
