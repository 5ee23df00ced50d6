// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace egomod {

// How far long work is: on a terminal a bar with rate and time left, elsewhere a line every 10 s or
// every 10 %, whichever comes later. Writes to stderr. Threads: one caller.
class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  // `total` 0: unknown.
  Progress(std::string label, std::string unit, std::uint64_t total);
  // For tests: where to, and whether that is a terminal.
  Progress(std::string label, std::string unit, std::uint64_t total, std::FILE* out,
           bool is_terminal);

  void update(std::uint64_t done, Clock::time_point now = Clock::now());
  // The last state, and the terminal's line is ended. Nothing if nothing was ever shown.
  void finish(std::uint64_t done, Clock::time_point now = Clock::now());

 private:
  void show(std::uint64_t done, Clock::time_point now);
  [[nodiscard]] bool is_due(std::uint64_t done, Clock::time_point now) const;

  std::string label_;
  std::string unit_;
  std::uint64_t total_;
  std::FILE* out_;
  bool is_terminal_;
  Clock::time_point begin_;
  Clock::time_point shown_at_;
  std::uint64_t shown_ = 0;
  bool is_shown_ = false;
};

}  // namespace egomod
