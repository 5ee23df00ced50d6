// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/pacer.hpp"

#include <chrono>

namespace egomod {

Nanoseconds monotonic_now() {
  return std::chrono::duration_cast<Nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch());
}

void Pacer::wait_for(Nanoseconds exposure, const std::stop_token& stop) {
  if (!offset_) {
    offset_ = monotonic_now() - exposure;
  }
  const std::chrono::steady_clock::time_point due(exposure + *offset_);
  std::unique_lock lock(mutex_);
  never_.wait_until(lock, stop, due, [] { return false; });
}

}  // namespace egomod
