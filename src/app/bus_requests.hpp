// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "egomod/bus/bus_address.hpp"
#include "egomod/capture/frame_source.hpp"

namespace lcm {
class LCM;
}

namespace egomod {

// What others ask of the running daemon over the bus: EGOMOD_CALIBRATION_SET takes effect between
// two pairs; EGOMOD_BLACKBOX is answered that there is no black box. An absent bus is tried again.
// Threads: one caller.
class BusRequests {
 public:
  // `source` must outlive the requests.
  BusRequests(BusAddress address, FrameSource& source);
  // For tests: on a bus that the caller made, which must outlive the requests.
  BusRequests(lcm::LCM& bus, FrameSource& source);
  BusRequests(const BusRequests&) = delete;
  BusRequests& operator=(const BusRequests&) = delete;
  ~BusRequests();

  // Handles what has come, without waiting; returns what the operator should know.
  [[nodiscard]] std::vector<std::string> handle();
  [[nodiscard]] std::uint64_t calibrations_refused() const { return refused_; }

 private:
  struct Handlers;  // keeps LCM's headers out

  void open();
  void subscribe();
  void set_calibration(const void* bytes, std::uint32_t size);
  void refuse_blackbox();

  BusAddress address_;
  FrameSource& source_;
  std::unique_ptr<lcm::LCM> own_bus_;
  lcm::LCM* bus_ = nullptr;
  std::vector<std::string> notices_;
  std::uint64_t refused_ = 0;
};

}  // namespace egomod
