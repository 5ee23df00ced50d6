// SPDX-License-Identifier: Apache-2.0
// Each stage and the whole, with default configurations: CPU time a pair at p50 and p99, also as a
// fraction of the yardstick Y; and how it grows with the size of the images and the number of
// tracks.
//   stages_bench [PASSES [MAX_TRACKS]]  a table of all stages on the sequence, quick
//   stages_bench --benchmark_...        the same as benchmarks of Google's, and the sweeps
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench_pairs.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "stage_runner.hpp"
#include "yardstick.hpp"

namespace egomod::bench {
namespace {

constexpr int kPasses = 3;
constexpr std::array<Stage, kStageCount> kStages{
    Stage::kCapture, Stage::kFeatures, Stage::kEgomotion, Stage::kMovingObjects, Stage::kPublish};

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Y before and after, since other work on the machine slows both.
class YardstickAround {
 public:
  explicit YardstickAround(const StereoPair& pair)
      : pair_(pair), before_s_(measure_yardstick_s(pair)) {}
  [[nodiscard]] double seconds() const { return 0.5 * (before_s_ + measure_yardstick_s(pair_)); }

 private:
  const StereoPair& pair_;
  double before_s_;
};

// The quick table.

// Sums over the stages from `from` to `to`, a pair each.
std::vector<double> sums(const std::vector<StageRunner::StageTimes>& times_s, Stage from,
                         Stage to) {
  std::vector<double> result_s;
  for (const StageRunner::StageTimes& pair_s : times_s) {
    result_s.push_back(std::accumulate(pair_s.begin() + static_cast<std::ptrdiff_t>(from),
                                       pair_s.begin() + static_cast<std::ptrdiff_t>(to) + 1, 0.0));
  }
  return result_s;
}

void print_row(const char* label, const std::vector<double>& times_s, double yardstick_s) {
  const double p50_s = quantile(times_s, 0.5), p99_s = quantile(times_s, 0.99);
  std::printf("%-22s %9.3f %9.3f %9.3f %9.3f\n", label, 1e3 * p50_s, 1e3 * p99_s,
              p50_s / yardstick_s, p99_s / yardstick_s);
}

struct TableRequest {
  int passes = 1;
  int max_tracks = 0;  // 0: as many as the instruction set bears
};

void print_table(const TableRequest& request) {
  StageRunner runner(load_pairs(), max_tracks({.max_tracks = request.max_tracks}));
  const YardstickAround yardstick(runner.first());
  std::vector<StageRunner::StageTimes> times_s;
  for (int i = 0; i < request.passes; ++i) {
    const auto pass_s = runner.pass_of_all();
    times_s.insert(times_s.end(), pass_s.begin(), pass_s.end());
  }
  const double yardstick_s = yardstick.seconds();
  std::printf("%s, %dx%d, %zu pairs x %d, %.0f tracks, %s, Y = %.2f ms\n", pairs_name().c_str(),
              runner.first().left.width_px(), runner.first().left.height_px(), runner.pairs(),
              request.passes, runner.mean_tracks(), name(instruction_set()).data(),
              1e3 * yardstick_s);
  std::printf("%-22s %9s %9s %9s %9s\n", "stage", "p50 ms", "p99 ms", "p50 Y", "p99 Y");
  for (const Stage stage : kStages)
    print_row(name(stage), sums(times_s, stage, stage), yardstick_s);
  print_row("features + egomotion", sums(times_s, Stage::kFeatures, Stage::kEgomotion),
            yardstick_s);
  print_row("whole", sums(times_s, Stage::kCapture, Stage::kPublish), yardstick_s);
}

// Benchmarks: an iteration is a pass, its time the mean of a pair.

void report(benchmark::State& state, const std::vector<double>& times_s, double yardstick_s) {
  const double p50_s = quantile(times_s, 0.5), p99_s = quantile(times_s, 0.99);
  state.counters["p50_ms"] = 1e3 * p50_s;
  state.counters["p99_ms"] = 1e3 * p99_s;
  state.counters["p50_Y"] = p50_s / yardstick_s;
  state.counters["p99_Y"] = p99_s / yardstick_s;
}

// Nothing for the stage: all of them.
std::vector<double> pass(StageRunner& runner, std::optional<Stage> stage) {
  return stage ? runner.pass(*stage) : sums(runner.pass_of_all(), Stage::kCapture, Stage::kPublish);
}

void run(benchmark::State& state, StageRunner& runner, std::optional<Stage> stage) {
  const YardstickAround yardstick(runner.first());
  std::vector<double> times_s;
  for (auto _ : state) {
    const std::vector<double> pass_s = pass(runner, stage);
    state.SetIterationTime(mean(pass_s));
    times_s.insert(times_s.end(), pass_s.begin(), pass_s.end());
  }
  report(state, times_s, yardstick.seconds());
}

benchmark::internal::Benchmark* configured(benchmark::internal::Benchmark* added) {
  return added->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(kPasses);
}

void add_stages(StageRunner& runner) {
  for (const Stage stage : kStages) {
    configured(benchmark::RegisterBenchmark(
        name(stage), [&runner, stage](benchmark::State& state) { run(state, runner, stage); }));
  }
  configured(benchmark::RegisterBenchmark(
      "whole", [&runner](benchmark::State& state) { run(state, runner, std::nullopt); }));
}

// A runner a size (with as many tracks a pixel in each) or a number of tracks, made when it is
// first asked for.
class Runners {
 public:
  StageRunner& of_width(int width_px) {
    auto& runner = by_width_[width_px];
    if (!runner) {
      const double scale = static_cast<double>(width_px) / kUsualWidth_px;
      const double tracks = max_tracks({}) * scale * scale;
      runner.emplace(rendered_pairs(width_px), static_cast<int>(std::lround(tracks)));
    }
    return *runner;
  }
  StageRunner& of_tracks(int max_tracks) {
    auto& runner = by_tracks_[max_tracks];
    if (!runner) runner.emplace(rendered_pairs(kSweptWidth_px), max_tracks);
    return *runner;
  }

 private:
  static constexpr int kUsualWidth_px = 640;
  static constexpr int kSweptWidth_px = 1280;  // with corners enough for all tracks
  std::map<int, std::optional<StageRunner>> by_width_;
  std::map<int, std::optional<StageRunner>> by_tracks_;
};

// Linear growth shows in an RMS of few per cent beside the fit.
void add_size_sweep(Runners& runners, const char* label, Stage stage) {
  configured(benchmark::RegisterBenchmark(
                 label,
                 [&runners, stage](benchmark::State& state) {
                   StageRunner& runner = runners.of_width(static_cast<int>(state.range(0)));
                   const Image& image = runner.first().left;
                   run(state, runner, stage);
                   state.SetComplexityN(std::int64_t{image.width_px()} * image.height_px());
                 }))
      ->ArgName("width_px")
      ->Arg(320)
      ->Arg(480)
      ->Arg(640)
      ->Arg(960)
      ->Arg(1280)
      ->Complexity(benchmark::oN);
}

void add_track_sweep(Runners& runners, const char* label, Stage stage) {
  configured(benchmark::RegisterBenchmark(label,
                                          [&runners, stage](benchmark::State& state) {
                                            StageRunner& runner =
                                                runners.of_tracks(static_cast<int>(state.range(0)));
                                            run(state, runner, stage);
                                            state.counters["tracks"] = runner.mean_tracks();
                                            state.SetComplexityN(std::lround(runner.mean_tracks()));
                                          }))
      ->ArgName("max_tracks")
      ->Arg(250)
      ->Arg(500)
      ->Arg(1000)
      ->Arg(2000)
      ->Complexity(benchmark::oN);
}

int run_benchmarks(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  StageRunner runner(load_pairs());
  Runners runners;
  benchmark::AddCustomContext("sequence", pairs_name());
  add_stages(runner);
  add_size_sweep(runners, "size/capture", Stage::kCapture);
  add_size_sweep(runners, "size/features", Stage::kFeatures);
  add_track_sweep(runners, "tracks/features", Stage::kFeatures);
  add_track_sweep(runners, "tracks/egomotion", Stage::kEgomotion);
  add_track_sweep(runners, "tracks/moving_objects", Stage::kMovingObjects);
  add_track_sweep(runners, "tracks/publish", Stage::kPublish);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

std::optional<int> positive_number(const char* text) {
  int number = 0;
  const char* const end = text + std::strlen(text);
  const auto parsed = std::from_chars(text, end, number);
  const bool is_number = parsed.ec == std::errc{} && parsed.ptr == end && number > 0;
  return is_number ? std::optional(number) : std::nullopt;
}

std::optional<TableRequest> table_from(int argc, char** argv) {
  if (argc > 3) return std::nullopt;
  const auto passes = argc > 1 ? positive_number(argv[1]) : 1;
  const auto tracks = argc > 2 ? positive_number(argv[2]) : 0;
  if (!passes || !tracks) return std::nullopt;
  return TableRequest{.passes = *passes, .max_tracks = *tracks};
}

}  // namespace
}  // namespace egomod::bench

int main(int argc, char** argv) {
  try {
    if (const auto request = egomod::bench::table_from(argc, argv)) {
      egomod::bench::print_table(*request);
      return 0;
    }
    return egomod::bench::run_benchmarks(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "stages_bench: %s\n", e.what());
    return 1;
  }
}
