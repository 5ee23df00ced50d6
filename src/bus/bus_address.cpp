// SPDX-License-Identifier: Apache-2.0
#include "egomod/bus/bus_address.hpp"

#include <algorithm>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <utility>

namespace egomod {
namespace {

constexpr std::chrono::seconds kLongestWait{30};

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
