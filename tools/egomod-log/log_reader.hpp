// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <string>

namespace egomod::log {

// A log that cannot be used: names file, place and remedy.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads an LCM log from front to back and notices where it is not whole.
class LogReader {
 public:
  // Throws LogError.
  explicit LogReader(std::string path);

  // Null at the end or where the log is cut off; valid until the next call.
  [[nodiscard]] const lcm::LogEvent* next();
  // Throws LogError when the log is cut off or holds bytes that are no event. To be called when all
  // that is whole has been used.
  void require_whole() const;
  [[nodiscard]] const std::string& damage() const { return damage_; }

  // Throws LogError when the event is not a `Message`.
  template <typename Message>
  void decode(const lcm::LogEvent& event, Message& message) const {
    if (message.decode(event.data, 0, event.datalen) < 0)
      fail_decode(event, Message::getTypeName());
  }

 private:
  [[noreturn]] void fail_decode(const lcm::LogEvent& event, const std::string& type) const;

  std::string path_;
  lcm::LogFile file_;
  std::int64_t size_bytes_ = 0;
  std::int64_t offset_bytes_ = 0;  // behind the last event
  std::string damage_;
};

// The type's fingerprint, with which each message begins; 0 if it is too short.
[[nodiscard]] std::int64_t fingerprint(const lcm::LogEvent& event);

}  // namespace egomod::log
