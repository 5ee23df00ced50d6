// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>

#include "egomod/core/time.hpp"

namespace egomod {

// Lets a replay run as fast as it was recorded: the first exposure is now, each later one as long
// after it as it was then. Threads: one caller.
class Pacer {
 public:
  // Sleeps until the exposure is due, or until a stop is requested.
  void wait_for(Nanoseconds exposure, const std::stop_token& stop);

 private:
  std::optional<Nanoseconds> offset_;  // monotonic clock minus exposure
  std::mutex mutex_;                   // condition_variable_any wants one; nobody else takes it
  std::condition_variable_any never_;
};

// Host monotonic clock.
[[nodiscard]] Nanoseconds monotonic_now();

}  // namespace egomod
