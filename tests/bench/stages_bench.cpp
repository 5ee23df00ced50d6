// SPDX-License-Identifier: Apache-2.0
// Features, egomotion and moving objects over a sequence with default configurations: CPU time a
// pair at p50 and p99, also as a fraction of the yardstick Y. Usage: stages_bench [passes]
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <vector>

#include "bench_pairs.hpp"
#include "egomod/core/frame.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
#include "yardstick.hpp"

namespace egomod::bench {
namespace {

constexpr std::size_t kRows = 4;
constexpr std::array<const char*, kRows> kRowNames{"features", "egomotion", "moving objects",
                                                   "whole"};
// The first pairs of a pass fill buffers and the map of tracks.
constexpr std::size_t kWarmUpPairs = 3;

using Samples = std::array<std::vector<double>, kRows>;

// One pass from a fresh start over all pairs.
void run_pass(const std::vector<StereoPair>& pairs, Samples& samples_s) {
  FeatureTracker tracker{FeaturesConfig{}};
  EgomotionEstimator estimator{EgomotionConfig{}};
  MovingObjectDetector detector{MovingObjectsConfig{}};
  TrackSet tracks;
  Egomotion motion;
  MovingObjects objects;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    std::array<double, kRows> t_s{cpu_seconds()};
    tracker.track(pairs[i], tracks);
    t_s[1] = cpu_seconds();
    estimator.estimate(tracks, motion);
    t_s[2] = cpu_seconds();
    detector.detect(tracks, motion, objects);
    t_s[3] = cpu_seconds();
    if (i < kWarmUpPairs) continue;
    for (std::size_t row = 0; row + 1 < kRows; ++row)
      samples_s[row].push_back(t_s[row + 1] - t_s[row]);
    samples_s[kRows - 1].push_back(t_s[3] - t_s[0]);
  }
}

double quantile(std::vector<double>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(share * last + 0.5)];
}

void report(Samples& samples_s, double yardstick_s) {
  std::printf("%-16s %9s %9s %9s %9s\n", "stage", "p50 ms", "p99 ms", "p50 Y", "p99 Y");
  for (std::size_t row = 0; row < kRows; ++row) {
    std::vector<double>& s = samples_s[row];
    std::sort(s.begin(), s.end());
    const double p50_s = quantile(s, 0.5), p99_s = quantile(s, 0.99);
    std::printf("%-16s %9.3f %9.3f %9.3f %9.3f\n", kRowNames[row], 1e3 * p50_s, 1e3 * p99_s,
                p50_s / yardstick_s, p99_s / yardstick_s);
  }
}

int passes_from(int argc, char** argv) {
  int passes = 1;
  if (argc < 2) return passes;
  const char* const end = argv[1] + std::strlen(argv[1]);
  const auto parsed = std::from_chars(argv[1], end, passes);
  if (argc > 2 || parsed.ec != std::errc{} || parsed.ptr != end || passes < 1)
    throw std::runtime_error("usage: stages_bench [passes], passes a whole number from 1");
  return passes;
}

void run(int passes) {
  const std::vector<StereoPair> pairs = load_pairs();
  if (pairs.size() <= kWarmUpPairs) throw std::runtime_error("the sequence is too short");
  // Before and after, since other work on the machine slows both sides.
  const double before_s = measure_yardstick_s(pairs.front());
  Samples samples_s;
  for (int pass = 0; pass < passes; ++pass) run_pass(pairs, samples_s);
  const double yardstick_s = 0.5 * (before_s + measure_yardstick_s(pairs.front()));
  std::printf("%s, %dx%d, %zu pairs x %d, Y = %.2f ms\n", pairs_name().c_str(),
              pairs.front().left.width_px(), pairs.front().left.height_px(), pairs.size(), passes,
              1e3 * yardstick_s);
  report(samples_s, yardstick_s);
}

}  // namespace
}  // namespace egomod::bench

int main(int argc, char** argv) {
  try {
    egomod::bench::run(egomod::bench::passes_from(argc, argv));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "stages_bench: %s\n", e.what());
    return 1;
  }
}
