// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod {

struct PipelineConfig {
  int slots = 10;              // frames in flight, filled in place
  bool single_thread = false;  // all stages in order on one thread, with capture's settings
  bool realtime = false;       // replays paced by exposure time, with the live policy
  int realtime_priority = 0;   // SCHED_FIFO of capture, one less for each later stage; 0: off
  std::string cpus{};          // one CPU for each stage, or one for all: "2,3,4,5,5"; empty: any
  bool lock_memory = false;    // mlockall
};

}  // namespace egomod
