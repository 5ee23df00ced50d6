// SPDX-License-Identifier: Apache-2.0
#include "speed.hpp"

#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <functional>

namespace egomod::sim {
namespace {

constexpr std::uint64_t kWarmUp = 5;  // the driver compiles at first use

std::string timed(const char* what, std::uint64_t count,
                  const std::function<void(std::uint64_t)>& take) {
  for (std::uint64_t i = 0; i < kWarmUp; ++i) take(i % count);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu_begin = std::clock();
  for (std::uint64_t i = 0; i < count; ++i) take(i);
  const double cpu_s = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const auto n = static_cast<double>(count);
  return fmt::format("{}: {:.1f} a second, {:.1f} ms each, {:.1f} ms of processor time\n", what,
                     n / took.count(), 1e3 * took.count() / n, 1e3 * cpu_s / n);
}

}  // namespace

std::string measure_speed(Simulator& simulator) {
  const World& world = simulator.world();
  const auto count = static_cast<std::uint64_t>(world.pairs());
  Image left;
  Image right;
  Truth truth;
  return fmt::format("{}, {}x{}, {} pairs, on {}\n", world.name, world.camera.width_px,
                     world.camera.height_px, count, simulator.device()) +
         timed("pairs", count,
               [&](std::uint64_t number) { simulator.take_pair(number, left, right); }) +
         timed("truth", count, [&](std::uint64_t number) { simulator.take_truth(number, truth); });
}

}  // namespace egomod::sim
