// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "bus_requests.hpp"
#include "egomod/app/progress.hpp"
#include "egomod/pipeline/pipeline.hpp"
#include "egomod/pipeline/stage_thread.hpp"
#include "egomod/publish/publisher.hpp"
#include "health.hpp"
#include "logging.hpp"
#include "run_summary.hpp"

namespace egomod {

// What is watched; everything outlives the supervisor.
struct Supervised {
  FrameSource& source;
  Pipeline& pipeline;
  Publisher& publisher;
  const RunSummary& summary;
  bool show_progress = false;
  double repeat_s = 10.0;
  BusAddress lcm_url{};  // where requests come from while the run is live
};

// The one place where signals are taken. Beside that it tells the operator, the bus and the service
// manager how the pipeline is, a few times a second, from a thread of its own.
class Supervisor {
 public:
  explicit Supervisor(const Supervised& supervised);
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;
  ~Supervisor();

  // The run has failed: the last health says so. Threads: any.
  void set_failed() { failed_ = true; }

 private:
  void loop();
  // The signal that came within a tick's time, 0 if none; kEnd when the run is over.
  [[nodiscard]] int wait_for_signal();
  void tick();
  void pass_on_warnings();
  void feed_watchdog(const PipelineStatistics& statistics);
  void report_health(const HealthInputs& inputs);

  Supervised supervised_;
  std::optional<Progress> progress_;
  WarningLimiter warnings_;
  HealthReporter health_;
  health_t health_message_;
  std::optional<BusRequests> requests_;  // live only: a replay must give the same each time
  std::atomic<bool> failed_{false};
  bool stopping_ = false;
  bool ready_ = false;
  std::uint64_t published_before_ = 0;
  int signal_fd_ = -1;
  int end_fd_ = -1;
  std::optional<StageThread> thread_;  // last: uses all the others
};

}  // namespace egomod
