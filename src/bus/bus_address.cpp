// SPDX-License-Identifier: Apache-2.0
#include "egomod/bus/bus_address.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <string_view>
#include <utility>

namespace egomod {
namespace {

constexpr std::chrono::seconds kLongestWait{30};
constexpr std::array<std::string_view, 5> kSchemes{"udpm", "mpudpm", "tcpq", "memq", "file"};

// As LCM takes it.
std::string in_force(const std::string& url) {
  const char* const from_environment = std::getenv("LCM_DEFAULT_URL");
  if (!url.empty() || from_environment == nullptr) return url;
  return from_environment;
}

}  // namespace

void Backoff::note_failure(Clock::time_point now) {
  next_ = now + wait_;
  wait_ = std::min(2 * wait_, kLongestWait);
}

struct BusAddress::Retry {
  std::mutex mutex;
  Backoff backoff;
};

BusAddress::BusAddress(std::string url) : url_(std::move(url)), retry_(std::make_shared<Retry>()) {}

std::string BusAddress::remedy() const {
  const std::string url = in_force(url_);
  const std::string scheme = url.empty() ? "udpm" : url.substr(0, url.find("://"));
  if (std::ranges::find(kSchemes, scheme) == kSchemes.end()) {
    return "unknown scheme, use udpm://239.255.76.67:7667?ttl=0 or another of LCM's: mpudpm://, "
           "tcpq://, memq://, file://";
  }
  if (scheme.ends_with("udpm")) {
    return "UDP multicast needs a route, and without a network this gives one: ip link set lo "
           "multicast on && ip route add 224.0.0.0/4 dev lo";
  }
  return scheme == "tcpq" ? "see whether an lcm-tcpq-server runs there"
                          : "see whether the URL is right";
}

std::unique_ptr<lcm::LCM> BusAddress::open() const { return open(url_); }

std::unique_ptr<lcm::LCM> BusAddress::open(const std::string& url) const {
  const std::lock_guard lock(retry_->mutex);
  if (!retry_->backoff.is_due(Backoff::Clock::now())) return nullptr;
  auto bus = std::make_unique<lcm::LCM>(url);
  if (!bus->good()) {
    retry_->backoff.note_failure(Backoff::Clock::now());
    return nullptr;
  }
  retry_->backoff.note_success();
  return bus;
}

}  // namespace egomod
