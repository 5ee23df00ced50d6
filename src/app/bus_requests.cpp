// SPDX-License-Identifier: Apache-2.0
#include "bus_requests.hpp"

#include <egomod/calibration_t.hpp>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "egomod/publish/messages.hpp"

namespace egomod {
namespace {

constexpr const char* kCalibrationSet = "EGOMOD_CALIBRATION_SET";
constexpr const char* kBlackbox = "EGOMOD_BLACKBOX";
constexpr int kMostAtOnce = 16;  // a flooded channel must not hold the caller

}  // namespace

struct BusRequests::Handlers {
  static void on_calibration(const lcm::ReceiveBuffer* buffer, const std::string&,
                             BusRequests* self) {
    self->set_calibration(buffer->data, buffer->data_size);
  }
  static void on_blackbox(const lcm::ReceiveBuffer*, const std::string&, BusRequests* self) {
    self->refuse_blackbox();
  }
};

BusRequests::BusRequests(BusAddress address, FrameSource& source)
    : address_(std::move(address)), source_(source) {
  open();
}

BusRequests::BusRequests(lcm::LCM& bus, FrameSource& source) : source_(source), bus_(&bus) {
  subscribe();
}

BusRequests::~BusRequests() = default;

void BusRequests::open() {
  own_bus_ = address_.open();
  bus_ = own_bus_.get();
  if (bus_ != nullptr) subscribe();
}

void BusRequests::subscribe() {
  bus_->subscribeFunction(kCalibrationSet, &Handlers::on_calibration, this);
  bus_->subscribeFunction(kBlackbox, &Handlers::on_blackbox, this);
}

std::vector<std::string> BusRequests::handle() {
  if (bus_ == nullptr) open();
  for (int i = 0; bus_ != nullptr && i < kMostAtOnce && bus_->handleTimeout(0) > 0; ++i) {
  }
  return std::exchange(notices_, {});
}

void BusRequests::set_calibration(const void* bytes, std::uint32_t size) {
  calibration_t message{};
  try {
    if (message.decode(bytes, 0, static_cast<int>(size)) < 0) {
      throw SourceError("is not an egomod.calibration_t of this version");
    }
    source_.set_calibration(calibration_from(message));
    notices_.push_back(std::string(kCalibrationSet) + ": taken, from the next pair on");
  } catch (const SourceError& error) {
    ++refused_;
    notices_.push_back(std::string(kCalibrationSet) + ": " + error.what() +
                       "; the old calibration stays");
  }
}

void BusRequests::refuse_blackbox() {
  notices_.push_back(std::string(kBlackbox) +
                     ": this version keeps no black box; record with --record");
}

}  // namespace egomod
