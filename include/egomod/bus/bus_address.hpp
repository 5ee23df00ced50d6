// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace lcm {
class LCM;
}

namespace egomod {

// When to try again what has failed: after 1 s, then each time twice as long, at most 30 s.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool is_due(Clock::time_point now) const { return !next_ || now >= *next_; }
  void note_failure(Clock::time_point now);
  void note_success() { *this = {}; }

 private:
  std::optional<Clock::time_point> next_;
  std::chrono::seconds wait_{1};
};

// Where the LCM bus is, and when it may be asked for again. Copies share the latter: liblcm fills a
// screen each time that it fails, so those who want the bus try as one. Threads: any.
class BusAddress {
 public:
  // Implicit, since a URL is an address. Empty: LCM_DEFAULT_URL, else LCM's own default.
  BusAddress(std::string url = {});
  BusAddress(const char* url) : BusAddress(std::string(url)) {}

  [[nodiscard]] const std::string& url() const { return url_; }
  // What to do about a bus that cannot be opened, to end a message.
  [[nodiscard]] std::string remedy() const;
  // Null if the bus cannot be opened, or could not a short while ago.
  [[nodiscard]] std::unique_ptr<lcm::LCM> open() const;
  // The same bus by a URL with further parameters.
  [[nodiscard]] std::unique_ptr<lcm::LCM> open(const std::string& url) const;

 private:
  struct Retry;

  std::string url_;
  std::shared_ptr<Retry> retry_;  // of all copies: source, publisher and requests
};

}  // namespace egomod
