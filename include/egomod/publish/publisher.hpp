// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "egomod/core/frame.hpp"
#include "egomod/publish/publish_config.hpp"

namespace egomod {

class health_t;  // <egomod/health_t.hpp>, of egomod::lcmtypes

// Counts since the start.
struct PublishStatistics {
  std::uint64_t sent = 0;        // messages the bus took
  std::uint64_t bus_errors = 0;  // messages it did not
  std::uint64_t not_finite = 0;  // messages, objects and tracks held back for a NaN or infinity
  std::string bus_problem{};     // with the remedy; empty: the last message went out
  std::string
      record_problem{};  // live: why the record stopped; empty: it goes on, or there is none
};

// The publish stage: each message is encoded once, and the same bytes go to the bus and to the
// record; order: pair, then CALIBRATION (first and on change), POSE, VELOCITY, OBJECTS, TRACKS,
// IMAGES, TIMING, and what the source has enclosed.
// Threads: `publish` and `close` from one, the rest from any.
class Publisher {
 public:
  // Throws RecordError when the record cannot be written. An absent bus is only a warning.
  Publisher(const PublishConfig& config, const PublishTarget& target);
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;
  ~Publisher();

  // In a replay throws RecordError when the record cannot be written on.
  void publish(const Frame& frame);
  // Bus only.
  void publish_health(const health_t& message);
  // The calibration in force once more, to the bus only, if a second has passed since it last went
  // out: for a live run, whether or not pairs come.
  void repeat_calibration();
  // Nothing of the record is left in memory. Throws RecordError, also live, when the record is not
  // whole.
  void close();

  [[nodiscard]] PublishStatistics statistics() const;
  // What the host should log: each new problem once, and its end.
  [[nodiscard]] std::vector<std::string> take_warnings();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace egomod
