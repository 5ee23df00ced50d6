// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace egomod {
namespace {

using namespace std::chrono_literals;

constexpr auto kTerminalInterval = 200ms;
constexpr auto kLineInterval = 10s;
constexpr std::uint64_t kLinesInAll = 10;

std::string bar(double share) {
  constexpr std::size_t kWidth = 30;
  const auto full = static_cast<std::size_t>(share * static_cast<double>(kWidth));
  return '[' + std::string(full, '#') + std::string(kWidth - full, '.') + ']';
}

std::string duration(double seconds) {
  const auto whole = std::llround(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string label, std::string unit, std::uint64_t total)
    : Progress(std::move(label), std::move(unit), total, stderr, isatty(STDERR_FILENO) == 1) {}

Progress::Progress(std::string label, std::string unit, std::uint64_t total, std::FILE* out,
                   bool is_terminal)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      total_(total),
      out_(out),
      is_terminal_(is_terminal),
      begin_(Clock::now()),
      shown_at_(begin_) {}

bool Progress::is_due(std::uint64_t done, Clock::time_point now) const {
  if (is_terminal_) {
    return now - shown_at_ >= kTerminalInterval;
  }
  const bool far_enough =
      total_ == 0 || done - shown_ >= std::max<std::uint64_t>(1, total_ / kLinesInAll);
  return now - shown_at_ >= kLineInterval && far_enough;
}

void Progress::update(std::uint64_t done, Clock::time_point now) {
  if (is_due(done, now)) {
    show(done, now);
  }
}

void Progress::finish(std::uint64_t done, Clock::time_point now) {
  if (!is_shown_) {
    return;
  }
  show(done, now);
  if (is_terminal_) {
    std::fputc('\n', out_);
  }
}

void Progress::show(std::uint64_t done, Clock::time_point now) {
  const double elapsed_s = std::max(1e-9, std::chrono::duration<double>(now - begin_).count());
  const double rate_hz = static_cast<double>(done) / elapsed_s;
  std::string text = label_ + ' ';
  if (total_ == 0) {
    text += fmt::format("{} {}, {:.1f} a second", done, unit_, rate_hz);
  } else {
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    const double left_s =
        done == 0 ? 0.0 : static_cast<double>(total_ - std::min(done, total_)) / rate_hz;
    text += fmt::format("{}{:3.0f} %  {} of {} {}, {:.1f} a second, {} left",
                        is_terminal_ ? bar(share) + ' ' : "", 100.0 * share, done, total_, unit_,
                        rate_hz, duration(left_s));
  }
  // \033[K: what a longer line left behind.
  std::fputs((is_terminal_ ? "\r" + text + "\033[K" : text + "\n").c_str(), out_);
  std::fflush(out_);
  shown_at_ = now;
  shown_ = done;
  is_shown_ = true;
}

}  // namespace egomod
