// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace egomod::demo {

struct PathComparison {
  int pairs = 0;
  double length_m = 0.0;     // of the true path
  double estimated_m = 0.0;  // of the estimated one
  double end_error_m = 0.0;
  double worst_error_m = 0.0;
};

struct ObjectComparison {
  int due = 0;                // pairs in which it moves in full view
  int found = 0;              // of these, with an estimate on it
  double first_seen_s = 0.0;  // after it was due first
  double speed_error_rms_mps = 0.0;
  double mean_speed_mps = 0.0;  // true
};

struct ObjectsComparison {
  std::map<int, ObjectComparison> objects;  // by the truth's id
  int estimates = 0;
  int strays = 0;  // estimates on nothing that moves
};

struct StageLatency {
  double median_ms = 0.0;
  double p99_ms = 0.0;
};

// `sequence` holds the truth (poses.txt, objects.csv), `result` what egomod-log export wrote.
[[nodiscard]] PathComparison compare_paths(const std::filesystem::path& sequence,
                                           const std::filesystem::path& result);
// An estimate is on an object when its rectangle overlaps the true one by an intersection over
// union of 0.3, or has its centre in it.
[[nodiscard]] ObjectsComparison compare_objects(const std::filesystem::path& sequence,
                                                const std::filesystem::path& result);
// Of timing.csv; empty without one.
[[nodiscard]] std::map<std::string, StageLatency> latencies(const std::filesystem::path& result);

// ": 1.23 % drift"; empty where the rig hardly moved, since a share of nothing says nothing.
[[nodiscard]] std::string drift_text(const PathComparison& path);
// The readable summary, on stdout.
void print_comparison(const std::filesystem::path& sequence, const std::filesystem::path& result,
                      double elapsed_s);

}  // namespace egomod::demo
