// SPDX-License-Identifier: Apache-2.0
#include "exposures.hpp"

#include <algorithm>
#include <random>

namespace egomod::sim {
namespace {

constexpr double kLargestJitter = 2.5;  // standard deviations
constexpr std::uint32_t kTimingKey = 0x7131;

// Random numbers of one exposure.
struct Chance {
  double jitter;  // standard normal
  double lost;    // 0 to 1, this and the next
  double late;
};

Chance chance(const World& world, Eye eye, std::uint64_t number) {
  std::seed_seq key{std::uint64_t{kTimingKey}, std::uint64_t{world.seed},
                    static_cast<std::uint64_t>(eye), number};
  std::mt19937 engine(key);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const double jitter = std::clamp(normal(engine), -kLargestJitter, kLargestJitter);
  const double lost = uniform(engine);
  return {jitter, lost, uniform(engine)};
}

}  // namespace

Exposure exposure(const World& world, Eye eye, std::uint64_t number) {
  const Timing& timing = world.timing;
  // One trigger for both cameras, unless each has a clock of its own.
  const Eye clock = timing.runs_free() ? eye : Eye::kLeft;
  double t_s = static_cast<double>(number) / world.rate_hz;
  if (clock == Eye::kRight)
    t_s = t_s * (1.0 + 1e-6 * timing.right_drift_ppm) + timing.right_offset_s;
  t_s += timing.jitter_s * chance(world, clock, number).jitter;
  if (clock == Eye::kLeft) t_s = std::max(0.0, t_s);
  const bool is_late = chance(world, eye, number).late < timing.late_probability;
  return {number, t_s, is_late ? timing.late_s : 0.0};
}

bool is_lost(const World& world, Eye eye, std::uint64_t number) {
  return world.timing.drop_probability > 0.0 &&
         chance(world, eye, number).lost < world.timing.drop_probability;
}

Exposure first_left_exposure(const World& world) {
  std::uint64_t number = 0;
  while (is_lost(world, Eye::kLeft, number)) ++number;
  return exposure(world, Eye::kLeft, number);
}

std::vector<Exposure> delivered(const World& world, Eye eye) {
  std::vector<Exposure> out;
  for (std::uint64_t number = 0;; ++number) {
    const Exposure next = exposure(world, eye, number);
    if (next.t_s >= world.duration_s - 1e-9) return out;
    if (next.t_s >= 0.0 && !is_lost(world, eye, number)) out.push_back(next);
  }
}

}  // namespace egomod::sim
