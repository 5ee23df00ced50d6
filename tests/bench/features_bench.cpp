// SPDX-License-Identifier: Apache-2.0
// The image primitives, each also as a fraction of the yardstick Y (counter "Y").
#include <benchmark/benchmark.h>

#include <cstdio>
#include <exception>
#include <vector>

#include "bench_pairs.hpp"
#include "egomod/features/corners.hpp"
#include "egomod/features/disparity_search.hpp"
#include "egomod/features/patch_search.hpp"
#include "egomod/features/pyramid.hpp"
#include "egomod/features/wide_matcher.hpp"
#include "yardstick.hpp"

namespace egomod::bench {
namespace {

constexpr int kTracks = 1000;
constexpr int kLevels = 4;

struct Scene {
  std::vector<StereoPair> pairs = load_pairs();
  double yardstick_s = measure_yardstick_s(pairs.front());

  [[nodiscard]] const StereoPair& first() const { return pairs.front(); }
  // One second later, or the last.
  [[nodiscard]] const StereoPair& far() const {
    for (const StereoPair& pair : pairs)
      if (to_seconds(pair.exposure - first().exposure) >= 1.0 - 1e-6) return pair;
    return pairs.back();
  }
};

class Stopwatch {
 public:
  Stopwatch(benchmark::State& state, double yardstick_s)
      : state_(state), yardstick_s_(yardstick_s), start_s_(cpu_seconds()) {}
  ~Stopwatch() {
    const double each_s =
        (cpu_seconds() - start_s_) /
        static_cast<double>(std::max<benchmark::IterationCount>(state_.iterations(), 1));
    state_.counters["Y"] = each_s / yardstick_s_;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  benchmark::State& state_;
  double yardstick_s_;
  double start_s_;
};

std::vector<Corner> detected(const Image& image, std::size_t limit) {
  CornerDetector detector({});
  std::vector<Corner> corners;
  detector.detect(image.view(), {}, 2.0F, corners);
  if (corners.size() > limit) corners.resize(limit);
  return corners;
}

std::vector<ImagePoint> positions(const std::vector<Corner>& corners) {
  std::vector<ImagePoint> points;
  for (const Corner& c : corners)
    points.push_back({static_cast<float>(c.position.u_px), static_cast<float>(c.position.v_px)});
  return points;
}

Pyramid pyramid_of(const Image& image) {
  Pyramid pyramid;
  pyramid.build(image.view(), kLevels);
  return pyramid;
}

void pyramids_of_a_pair(benchmark::State& state, const Scene& scene) {
  Pyramid left, right;
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state) {
    left.build(scene.first().left.view(), kLevels);
    right.build(scene.first().right.view(), kLevels);
    benchmark::ClobberMemory();
  }
}

// The argument: tracks that the image already has.
void corners(benchmark::State& state, const Scene& scene) {
  const auto old =
      positions(detected(scene.first().left, static_cast<std::size_t>(state.range(0))));
  CornerDetector detector({});
  std::vector<Corner> found;
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state) {
    detector.detect(scene.first().left.view(), old, 1.0F, found);
    benchmark::DoNotOptimize(found.data());
  }
  state.counters["corners"] = static_cast<double>(found.size());
}

void disparities(benchmark::State& state, const Scene& scene) {
  const Pyramid left = pyramid_of(scene.first().left), right = pyramid_of(scene.first().right);
  std::vector<PixelPosition> points;
  for (const Corner& c : detected(scene.first().left, static_cast<std::size_t>(state.range(0))))
    points.push_back(c.position);
  std::vector<DisparityMatch> matches(points.size());
  DisparitySearch search({.max_disparity_px = 256});
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state) {
    search.search(left, right, points, matches);
    benchmark::DoNotOptimize(matches.data());
  }
  state.counters["points"] = static_cast<double>(points.size());
}

// The argument: radius on level 1.
void patch_searches(benchmark::State& state, const Scene& scene) {
  const Pyramid before = pyramid_of(scene.pairs[0].left), after = pyramid_of(scene.pairs[1].left);
  std::vector<SearchPatch> patches;
  std::vector<PixelPosition> places;
  for (const ImagePoint p : positions(detected(scene.first().left, kTracks))) {
    const PixelPosition top_left = patch_top_left(to_level(p, 1));
    SearchPatch patch;
    if (!copy_patch(before.level(1), top_left, patch)) continue;
    patches.push_back(patch);
    places.push_back(top_left);
  }
  PatchSearch search;
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state)
    for (std::size_t i = 0; i < patches.size(); ++i)
      benchmark::DoNotOptimize(
          search.search(after.level(1), patches[i], places[i], static_cast<int>(state.range(0))));
  state.counters["points"] = static_cast<double>(patches.size());
}

std::vector<DescribedPoint> described(const Pyramid& pyramid, const std::vector<Corner>& corners) {
  std::vector<DescribedPoint> points;
  for (const Corner& c : corners) {
    DescribedPoint p{
        .position = {static_cast<float>(c.position.u_px), static_cast<float>(c.position.v_px)},
        .kind = c.kind,
        .descriptor = {}};
    if (describe(pyramid, p.position, p.descriptor)) points.push_back(p);
  }
  return points;
}

void descriptors(benchmark::State& state, const Scene& scene) {
  const Pyramid pyramid = pyramid_of(scene.first().left);
  const auto corners = detected(scene.first().left, kTracks);
  Descriptor descriptor;
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state)
    for (const Corner& c : corners)
      benchmark::DoNotOptimize(describe(
          pyramid, {static_cast<float>(c.position.u_px), static_cast<float>(c.position.v_px)},
          descriptor));
}

// The argument: radius in per mille of the width.
void wide_matches(benchmark::State& state, const Scene& scene) {
  const auto olds =
      described(pyramid_of(scene.first().left), detected(scene.first().left, kTracks));
  const auto news = described(pyramid_of(scene.far().left), detected(scene.far().left, kTracks));
  const float radius_px =
      1e-3F * static_cast<float>(state.range(0) * scene.first().left.width_px());
  std::vector<WideMatch> matches(olds.size());
  WideMatcher matcher({});
  Stopwatch watch(state, scene.yardstick_s);
  for (auto _ : state) {
    matcher.match(olds, news, radius_px, matches);
    benchmark::DoNotOptimize(matches.data());
  }
  state.counters["matches"] = static_cast<double>(std::count_if(
      matches.begin(), matches.end(), [](const WideMatch& m) { return m.candidate >= 0; }));
}

using Body = void (*)(benchmark::State&, const Scene&);

benchmark::internal::Benchmark* add(const char* name, Body body, const Scene& scene) {
  return benchmark::RegisterBenchmark(
             name, [body, &scene](benchmark::State& state) { body(state, scene); })
      ->Unit(benchmark::kMicrosecond)
      ->MinTime(0.2);
}

int run(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  const Scene scene;
  std::printf("%s, %dx%d, Y = %.2f ms\n", pairs_name().c_str(), scene.first().left.width_px(),
              scene.first().left.height_px(), 1e3 * scene.yardstick_s);
  add("pyramids_of_a_pair", pyramids_of_a_pair, scene);
  add("corners", corners, scene)->Arg(0)->Arg(750)->Arg(1000);
  add("disparities", disparities, scene)->Arg(200)->Arg(1000);
  add("patch_searches", patch_searches, scene)->Arg(4)->Arg(8)->Arg(16);
  add("descriptors", descriptors, scene);
  add("wide_matches", wide_matches, scene)->Arg(100)->Arg(625);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace egomod::bench

int main(int argc, char** argv) {
  try {
    return egomod::bench::run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "features_bench: %s\n", e.what());
    return 1;
  }
}
