// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "egomod/core/time.hpp"

namespace egomod {

// Notices pairs that are missing by how late the next one comes: images that a camera or a disk
// lost leave no gap in the sequence numbers. A new, lower rate is late once. Threads: one caller.
class IntervalWatch {
 public:
  // To be called for each pair of the stream, in order.
  [[nodiscard]] bool is_late(Nanoseconds exposure);

 private:
  [[nodiscard]] Nanoseconds usual() const;

  std::array<Nanoseconds, 3> intervals_{};  // the last ones
  std::size_t count_ = 0;                   // of all intervals
  bool started_ = false;
  Nanoseconds last_exposure_{0};
};

}  // namespace egomod
