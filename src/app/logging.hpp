// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <string_view>

#include "egomod/app/config.hpp"

namespace egomod {

// The program's log goes to stderr: with the time for people, with <priority> for the journal,
// which has the time itself.
void set_up_logging(LogLevel level);

// Lets a warning that repeats through at most once in a while, with a count of what was held back.
// Threads: one caller.
class WarningLimiter {
 public:
  using Clock = std::chrono::steady_clock;

  explicit WarningLimiter(double repeat_s) : repeat_s_(repeat_s) {}
  void warn(const std::string& text, Clock::time_point now = Clock::now());
  // What `warn` logs; empty: held back.
  [[nodiscard]] std::string passed(const std::string& text, Clock::time_point now);

 private:
  // Kinds of warnings told apart; further ones share the last place.
  static constexpr std::size_t kMaxKinds = 64;
  struct Seen {
    Clock::time_point last;
    std::uint64_t held_back = 0;
  };

  double repeat_s_;
  std::map<std::string, Seen> seen_;
};

}  // namespace egomod
