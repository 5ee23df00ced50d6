// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <egomod/command_t.hpp>
#include <egomod/odometry_t.hpp>
#include <memory>
#include <optional>
#include <string>

#include "driven_base.hpp"

namespace egomod::sim {

inline constexpr const char* kOdometryChannel = "PIONEER_ODOMETRY";

// What the base reports at a simulated time.
[[nodiscard]] odometry_t odometry(const BaseState& state, double t_s, std::int64_t sequence);

// Turns messages into commands of the simulated base. Simulated time begins at 0; a utime of a
// clock that counts from the epoch says nothing about it, and such a command holds from its
// arrival. Threads: one caller.
class CommandReader {
 public:
  explicit CommandReader(double watchdog_s) : watchdog_s_(watchdog_s) {}
  // Nothing for what is no command, or not newer than the last that still holds.
  [[nodiscard]] std::optional<DriveCommand> read(const command_t& message, double now_s);

 private:
  double watchdog_s_;
  std::optional<std::int64_t> sequence_;
  double holds_until_s_ = 0.0;
};

// The base on the bus: PIONEER_COMMAND in, PIONEER_ODOMETRY out, utime in simulated time. Without a
// bus it stands still, and says so on stderr once. Threads: one caller.
class BaseLink {
 public:
  BaseLink(const std::string& lcm_url, DrivenBase& base);
  BaseLink(const BaseLink&) = delete;
  BaseLink& operator=(const BaseLink&) = delete;
  ~BaseLink();

  // Gives the base all commands that have come, without waiting.
  void take_commands();
  // The base must know the time given.
  void publish_odometry(double until_s);

 private:
  struct Bus;  // keeps LCM's headers out

  DrivenBase& base_;
  CommandReader reader_;
  std::unique_ptr<Bus> bus_;
  std::int64_t published_ = 0;
};

}  // namespace egomod::sim
