// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "capture/image_message.hpp"

namespace egomod {

struct LogEvent {
  std::int64_t number = 0;
  std::int64_t utime_us = 0;
  std::string channel;
  std::uint64_t data_offset = 0;  // in the file
  std::uint32_t data_bytes = 0;
};

// An LCM log, read at any place. liblcm's own reader cannot tell a truncated log from its end, and
// reads every pixel to find the next event.
class LogFile {
 public:
  // Throws SourceError.
  explicit LogFile(std::string path);
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  // The next event; nothing at the end of the log or where it is damaged, see `damage`.
  [[nodiscard]] std::optional<LogEvent> next_event();
  // Why the events ended before the file did; empty if they did not.
  [[nodiscard]] const std::string& damage() const { return damage_; }

  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::uint8_t> to) const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  void set_damage(const std::string& what);

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_bytes_ = 0;
  std::uint64_t position_ = 0;
  std::uint64_t events_ = 0;
  std::string damage_;
};

// One event's message.
class LogMessageReader final : public MessageReader {
 public:
  LogMessageReader(const LogFile& log, const LogEvent& event) : log_(log), event_(event) {}
  [[nodiscard]] bool fetch(std::uint64_t offset, std::span<std::uint8_t> to) override;
  [[nodiscard]] std::uint64_t size_bytes() const override { return event_.data_bytes; }

 private:
  const LogFile& log_;
  const LogEvent& event_;
};

}  // namespace egomod
