// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "egomod/core/frame.hpp"
#include "egomod/pipeline/pipeline_statistics.hpp"

namespace egomod {

struct ObjectSummary {
  Nanoseconds first_seen{0};
  Nanoseconds last_seen{0};
  std::uint64_t pairs = 0;
  double speed_sum_mps = 0.0;
  double speed_sigma_sum_mps = 0.0;
};

struct RunFigures {
  std::optional<Nanoseconds> first_exposure;
  Nanoseconds last_exposure{0};
  std::int64_t last_sequence = -1;
  std::uint32_t resets = 0;
  std::uint64_t failed = 0;
  std::uint64_t ambiguous = 0;
  std::uint64_t breaks = 0;
  double path_m = 0.0;
  RightCameraTurn right_turn;
  std::map<std::int64_t, ObjectSummary> objects;  // those that moved, the first kMaxObjects
  std::uint64_t further_objects_pairs = 0;        // sightings of later ones
};

// What a run has seen. Threads: `add` one, `figures` any.
class RunSummary {
 public:
  static constexpr std::size_t kMaxObjects = 1000;

  void add(const Frame& frame);
  [[nodiscard]] RunFigures figures() const;

 private:
  void add_objects(const MovingObjects& objects);

  mutable std::mutex mutex_;
  RunFigures figures_;
};

// For people, aligned.
[[nodiscard]] std::string summary_text(const RunFigures& figures,
                                       const PipelineStatistics& statistics, double elapsed_s,
                                       const std::string& record);

}  // namespace egomod
