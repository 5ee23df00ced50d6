// SPDX-License-Identifier: Apache-2.0
#include "run_summary.hpp"

#include <fmt/format.h>

#include "egomod/core/speed_units.hpp"

namespace egomod {
namespace {

std::string line(std::string_view label, const std::string& text) {
  return fmt::format("{:<16}{}\n", label, text);
}

std::string latencies(const PipelineStatistics& statistics) {
  std::string text = fmt::format("{:<16}{:>10}{:>10}{:>10}\n", "latency, ms", "p50", "p99", "max");
  const auto row = [&](std::string_view label, const LatencySummary& latency) {
    text +=
        fmt::format("  {:<14}{:>10.2f}{:>10.2f}{:>10.2f}\n", label, to_milliseconds(latency.p50),
                    to_milliseconds(latency.p99), to_milliseconds(latency.max));
  };
  for (std::size_t i = 0; i < kStageCount; ++i) {
    row(name(static_cast<Stage>(i)), statistics.stages[i]);
  }
  row("whole", statistics.total);
  return text;
}

// In m/s and km/h, with the mean standard error of a pair's speed: errors of successive pairs
// agree, so that the mean of many is hardly more certain.
std::string mean_speed(const ObjectSummary& object) {
  const auto pairs = static_cast<double>(object.pairs);
  const double mean_mps = object.speed_sum_mps / pairs;
  const double sigma_mps = object.speed_sigma_sum_mps / pairs;
  return fmt::format("{:>10.2f} ± {:.2f}{:>10.1f} ± {:>4.1f}", mean_mps, sigma_mps,
                     kKmhPerMps * mean_mps, kKmhPerMps * sigma_mps);
}

std::string objects_seen(const RunFigures& figures) {
  if (figures.objects.empty()) {
    return line("objects", "none seen to move");
  }
  std::string text = line("objects", fmt::format("{} seen to move", figures.objects.size()));
  text += fmt::format("  {:>6}{:>10}{:>10}{:>8}{:>17}{:>17}\n", "id", "from, s", "to, s", "pairs",
                      "speed, m/s", "km/h");
  constexpr std::size_t kMaxRows = 20;
  std::size_t rows = 0;
  for (const auto& [id, object] : figures.objects) {
    if (++rows > kMaxRows) {
      return text + fmt::format("  and {} more\n", figures.objects.size() - kMaxRows);
    }
    const Nanoseconds begin = figures.first_exposure.value_or(Nanoseconds(0));
    text +=
        fmt::format("  {:>6}{:>10.2f}{:>10.2f}{:>8}{}\n", id, to_seconds(object.first_seen - begin),
                    to_seconds(object.last_seen - begin), object.pairs, mean_speed(object));
  }
  return text;
}

bool has_moved(const Egomotion& motion) {
  return motion.status == EstimateStatus::kValid || motion.status == EstimateStatus::kAmbiguous;
}

}  // namespace

void RunSummary::add(const Frame& frame) {
  const std::lock_guard lock(mutex_);
  const Egomotion& motion = frame.motion;
  figures_.first_exposure = figures_.first_exposure.value_or(frame.pair.exposure);
  figures_.last_exposure = frame.pair.exposure;
  figures_.last_sequence = static_cast<std::int64_t>(frame.pair.sequence);
  figures_.resets = motion.reset_count;
  figures_.failed += motion.status == EstimateStatus::kFailed ? 1 : 0;
  figures_.ambiguous += motion.status == EstimateStatus::kAmbiguous ? 1 : 0;
  figures_.breaks += frame.pair.discontinuity ? 1 : 0;
  figures_.right_turn = frame.tracks.right_turn;
  figures_.path_m += has_moved(motion) ? motion.T_previous_current.translation().norm() : 0.0;
  if (frame.objects.has_run) {
    add_objects(frame.objects);
  }
}

void RunSummary::add_objects(const MovingObjects& objects) {
  for (const MovingObject& object : objects.objects) {
    if (object.state != ObjectState::kMoving) {
      continue;
    }
    if (!figures_.objects.contains(object.id) && figures_.objects.size() >= kMaxObjects) {
      ++figures_.further_objects_pairs;
      continue;
    }
    const auto [entry, is_new] =
        figures_.objects.try_emplace(object.id, ObjectSummary{.first_seen = objects.exposure});
    entry->second.last_seen = objects.exposure;
    ++entry->second.pairs;
    entry->second.speed_sum_mps += object.speed_mps;
    entry->second.speed_sigma_sum_mps += object.speed_sigma_mps;
  }
}

RunFigures RunSummary::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

std::string summary_text(const RunFigures& figures, const PipelineStatistics& statistics,
                         double elapsed_s, const std::string& record) {
  const double rate_hz = static_cast<double>(statistics.published) / elapsed_s;
  const Nanoseconds begin = figures.first_exposure.value_or(figures.last_exposure);
  std::string text;
  text += line("pairs",
               fmt::format("{} of {:.2f} s, in {:.2f} s: {:.1f} a second", statistics.published,
                           to_seconds(figures.last_exposure - begin), elapsed_s, rate_hz));
  text += line("left out", fmt::format("{} skipped, {} rejected, {} dropped", statistics.skipped,
                                       statistics.rejected, statistics.dropped));
  text += line("motion", fmt::format("{} failed, {} ambiguous, {} resets", figures.failed,
                                     figures.ambiguous, figures.resets));
  text += line("path", fmt::format("{:.2f} m", figures.path_m));
  text += latencies(statistics);
  text += objects_seen(figures);
  text += line("record", record.empty() ? "none (--record FILE)" : record);
  return text;
}

}  // namespace egomod
