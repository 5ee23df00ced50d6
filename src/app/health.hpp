// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <egomod/health_t.hpp>
#include <optional>
#include <string>

#include "egomod/capture/frame_source.hpp"
#include "egomod/pipeline/pipeline_statistics.hpp"
#include "egomod/publish/publisher.hpp"
#include "run_summary.hpp"

namespace egomod {

// Everything a health message is made of.
struct HealthInputs {
  PipelineStatistics pipeline;
  PublishStatistics publish;
  RunFigures run;
  SourceCounters source;
  std::uint64_t calibrations_refused = 0;
  bool stopping = false;
  bool failed = false;
};

// A sentence for people.
[[nodiscard]] std::string miscalibration(const RightCameraTurn& turn);

// Turns counts since the start into EGOMOD_HEALTH: each second, and at once when the state or a
// fault changes. A fault stands as long as its count grew within the last second.
// Threads: one caller.
class HealthReporter {
 public:
  using Clock = std::chrono::steady_clock;

  // True: `message` is due.
  [[nodiscard]] bool report(const HealthInputs& inputs, Clock::time_point now, health_t& message);

 private:
  [[nodiscard]] std::int64_t faults(const HealthInputs& inputs) const;

  HealthInputs before_;  // a second ago
  Clock::time_point before_at_ = Clock::now();
  double capture_rate_hz_ = 0.0;
  double publish_rate_hz_ = 0.0;
  std::int64_t standing_faults_ = 0;
  std::int64_t sent_faults_ = -1;
  std::optional<std::int8_t> sent_state_;
};

}  // namespace egomod
