// SPDX-License-Identifier: Apache-2.0
#include "base_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>

#include "egomod/bus/bus_address.hpp"

namespace egomod::sim {
namespace {

constexpr const char* kCommandChannel = "PIONEER_COMMAND";
constexpr std::int64_t kEpochClocks_us = 1'000'000'000'000'000;  // September 2001
constexpr double kBattery_v = 12.5;

}  // namespace

odometry_t odometry(const BaseState& state, double t_s, std::int64_t sequence) {
  odometry_t message{};
  message.utime = std::llround(1e6 * t_s);
  message.sequence = sequence;
  message.x = state.odometry_x_m;
  message.y = state.odometry_y_m;
  message.heading = state.odometry_heading_rad;
  message.linear = state.linear_mps;
  message.angular = state.angular_radps;
  message.battery = kBattery_v;
  message.motors_enabled = 1;
  message.left_stalled = state.stalled ? 1 : 0;
  message.right_stalled = message.left_stalled;
  return message;
}

std::optional<DriveCommand> CommandReader::read(const command_t& message, double now_s) {
  const bool is_command = std::isfinite(message.linear) && std::isfinite(message.angular) &&
                          std::isfinite(message.valid_for);
  const bool is_newer = !sequence_ || message.sequence > *sequence_ || now_s >= holds_until_s_;
  if (!is_command || !is_newer) return std::nullopt;
  const double sent_s =
      message.utime < kEpochClocks_us ? 1e-6 * static_cast<double>(message.utime) : now_s;
  sequence_ = message.sequence;
  holds_until_s_ = std::max(sent_s, now_s) + watchdog_s_;
  return DriveCommand{.from_s = std::max(sent_s, now_s),
                      .linear_mps = message.linear,
                      .angular_radps = message.angular,
                      .until_s = std::min(sent_s + message.valid_for, holds_until_s_)};
}

struct BaseLink::Bus {
  Bus(const std::string& url, BaseLink& link) : lcm(url), owner(link) {
    if (lcm.good()) lcm.subscribeFunction(kCommandChannel, &Bus::on_command, &owner);
  }
  static void on_command(const lcm::ReceiveBuffer* buffer, const std::string& /*channel*/,
                         BaseLink* link) {
    command_t message{};
    if (message.decode(buffer->data, 0, static_cast<int>(buffer->data_size)) < 0) return;
    const auto command = link->reader_.read(message, link->base_.now_s());
    if (command) link->base_.accept(*command);
  }

  lcm::LCM lcm;
  BaseLink& owner;
};

BaseLink::BaseLink(const std::string& lcm_url, DrivenBase& base)
    : base_(base), reader_(base.drive().watchdog_s), bus_(std::make_unique<Bus>(lcm_url, *this)) {
  if (bus_->lcm.good()) return;
  std::fprintf(stderr,
               "egomod-sim: the LCM bus (URL: %s) cannot be opened, so that nobody can drive the "
               "rig; %s\n",
               lcm_url.empty() ? "the default" : lcm_url.c_str(),
               BusAddress(lcm_url).remedy().c_str());
}

BaseLink::~BaseLink() = default;

void BaseLink::take_commands() {
  while (bus_->lcm.good() && bus_->lcm.handleTimeout(0) > 0) {
  }
}

void BaseLink::publish_odometry(double until_s) {
  const double interval_s = 1.0 / base_.drive().odometry_rate_hz;
  for (;; ++published_) {
    const double t_s = interval_s * static_cast<double>(published_);
    if (t_s > until_s) return;
    const odometry_t message = odometry(base_.at(t_s), t_s, published_);
    if (bus_->lcm.good()) bus_->lcm.publish(kOdometryChannel, &message);
  }
}

}  // namespace egomod::sim
