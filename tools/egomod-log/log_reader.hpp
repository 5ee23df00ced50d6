// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace egomod {
class LogFile;
}  // namespace egomod

namespace egomod::log {

// A log that cannot be used: names file, place and remedy.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads an LCM log from front to back and notices where it is not whole. The daemon's reader finds
// the events: liblcm's own believes lengths that are damaged.
class LogReader {
 public:
  // Throws LogError.
  explicit LogReader(const std::string& path);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  // Null at the end or where the log is damaged; valid until the next call.
  [[nodiscard]] const lcm::LogEvent* next();
  // Throws LogError when the log is damaged. To be called when all that is whole has been used.
  void require_whole() const;
  [[nodiscard]] const std::string& damage() const;

  // Throws LogError when the event is not a `Message`.
  template <typename Message>
  void decode(const lcm::LogEvent& event, Message& message) const {
    // A list's decoder takes memory for as many as the count says, before it looks for them.
    if constexpr (
        requires { message.n_objects; } || requires { message.n_tracks; }) {
      if (!list_fits(event)) fail_decode(event, Message::getTypeName());
    }
    bool is_message = false;
    try {
      is_message = message.decode(event.data, 0, event.datalen) >= 0;
    } catch (const std::exception&) {
      // A count that is damaged: no such array can be had.
    }
    if (!is_message) fail_decode(event, Message::getTypeName());
  }

 private:
  // Lists begin with fingerprint, utime and sequence; then comes the count.
  [[nodiscard]] static bool list_fits(const lcm::LogEvent& event);
  [[noreturn]] void fail_decode(const lcm::LogEvent& event, const std::string& type) const;

  std::unique_ptr<LogFile> file_;
  lcm::LogEvent event_{};
  std::vector<std::uint8_t> data_;
};

// The type's fingerprint, with which each message begins; 0 if it is too short.
[[nodiscard]] std::int64_t fingerprint(const lcm::LogEvent& event);

}  // namespace egomod::log
