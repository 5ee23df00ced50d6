// SPDX-License-Identifier: Apache-2.0
#include "health.hpp"

#include <fmt/format.h>

#include <numbers>

namespace egomod {
namespace {

using namespace std::chrono_literals;

stage_latency_t latency_of(const char* stage, const LatencySummary& latency) {
  stage_latency_t message;
  message.name = stage;
  message.p50 = to_milliseconds(latency.p50);
  message.p99 = to_milliseconds(latency.p99);
  message.max = to_milliseconds(latency.max);
  return message;
}

// Lowest bit first, as health_t wants it.
std::vector<std::string> sentences(std::int64_t faults, const HealthInputs& inputs) {
  const PipelineStatistics& pipeline = inputs.pipeline;
  const std::pair<std::int64_t, std::string> all[] = {
      {health_t::FAULT_NO_PAIRS, "the source delivers no pairs"},
      {health_t::FAULT_PAIRS_REJECTED,
       fmt::format("pairs cannot be used, {} so far", pipeline.rejected)},
      {health_t::FAULT_PAIRS_DROPPED,
       fmt::format("the stages cannot keep up, {} pairs dropped so far", pipeline.dropped_usable)},
      {health_t::FAULT_STREAM_BROKEN, fmt::format("the stream broke, {} times", inputs.run.breaks)},
      {health_t::FAULT_NO_MOTION,
       fmt::format("no motion could be estimated in {} pairs", inputs.run.failed)},
      {health_t::FAULT_AMBIGUOUS,
       fmt::format("geometry could not tell who moves in {} pairs", inputs.run.ambiguous)},
      {health_t::FAULT_BUS, inputs.publish.bus_problem},
      {health_t::FAULT_RECORD, inputs.publish.record_problem},
      {health_t::FAULT_NOT_FINITE,
       fmt::format("{} estimates were not finite and held back", inputs.publish.not_finite)},
      {health_t::FAULT_CALIBRATION,
       fmt::format("{} new calibrations were refused so far", inputs.calibrations_refused)},
      {health_t::FAULT_IMAGES, fmt::format("{} images lost, {} dropped, {} messages damaged so far",
                                           inputs.source.lost_images, inputs.source.dropped_images,
                                           inputs.source.damaged_messages)},
      {health_t::FAULT_MISCALIBRATED, miscalibration(inputs.run.right_turn)},
  };
  std::vector<std::string> texts;
  for (const auto& [bit, text] : all) {
    if ((faults & bit) != 0) {
      texts.push_back(text);
    }
  }
  return texts;
}

std::int8_t state_of(std::int64_t faults, const HealthInputs& inputs) {
  if (inputs.failed) {
    return health_t::STATE_FAILED;
  }
  if (inputs.stopping) {
    return health_t::STATE_STOPPING;
  }
  if (inputs.pipeline.published == 0) {
    return health_t::STATE_STARTING;
  }
  return faults == 0 ? health_t::STATE_RUNNING : health_t::STATE_DEGRADED;
}

void fill(const HealthInputs& inputs, std::int64_t faults, health_t& message) {
  const PipelineStatistics& pipeline = inputs.pipeline;
  message.utime = std::chrono::duration_cast<std::chrono::microseconds>(
                      std::chrono::system_clock::now().time_since_epoch())
                      .count();
  message.sequence = inputs.run.last_sequence;
  message.fault_bits = faults;
  message.faults = sentences(faults, inputs);
  message.n_faults = static_cast<std::int32_t>(message.faults.size());
  message.captured = static_cast<std::int64_t>(pipeline.captured);
  message.rejected = static_cast<std::int64_t>(pipeline.rejected);
  message.skipped = static_cast<std::int64_t>(pipeline.skipped);
  message.dropped = static_cast<std::int64_t>(pipeline.dropped);
  message.published = static_cast<std::int64_t>(pipeline.published);
  message.not_finite = static_cast<std::int64_t>(inputs.publish.not_finite);
  message.lost_images = static_cast<std::int64_t>(inputs.source.lost_images);
  message.dropped_images = static_cast<std::int64_t>(inputs.source.dropped_images);
  message.damaged_messages = static_cast<std::int64_t>(inputs.source.damaged_messages);
  message.bus_errors = static_cast<std::int64_t>(inputs.publish.bus_errors);
  message.skew = to_milliseconds(pipeline.last_skew);
  message.skew_max = to_milliseconds(pipeline.max_skew);
  message.reset_count = static_cast<std::int32_t>(inputs.run.resets);
  message.stages.clear();
  for (std::size_t i = 0; i < kStageCount; ++i) {
    message.stages.push_back(latency_of(name(static_cast<Stage>(i)), pipeline.stages[i]));
  }
  message.stages.push_back(latency_of("total", pipeline.total));
  message.n_stages = static_cast<std::int32_t>(message.stages.size());
}

}  // namespace

std::string miscalibration(const RightCameraTurn& turn) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return fmt::format(
      "the right camera seems turned against its calibration by {:.2f}° in pitch, {:.2f}° (± "
      "{:.2f}°) in yaw and {:.2f}° in roll; that is taken out as far as it is known: calibrate the "
      "rig anew",
      kDegrees * turn.turn_rad.x(), kDegrees * turn.turn_rad.y(), kDegrees * turn.yaw_sigma_rad,
      kDegrees * turn.turn_rad.z());
}

std::int64_t HealthReporter::faults(const HealthInputs& inputs) const {
  const PipelineStatistics& now = inputs.pipeline;
  const PipelineStatistics& before = before_.pipeline;
  std::int64_t bits = 0;
  const auto set = [&](bool is_set, std::int64_t bit) { bits |= is_set ? bit : 0; };
  set(now.rejected > before.rejected, health_t::FAULT_PAIRS_REJECTED);
  // That newer ones overtake pairs which cannot be used says nothing of the stages.
  set(now.dropped_usable > before.dropped_usable, health_t::FAULT_PAIRS_DROPPED);
  set(inputs.run.breaks > before_.run.breaks, health_t::FAULT_STREAM_BROKEN);
  set(inputs.run.failed > before_.run.failed, health_t::FAULT_NO_MOTION);
  set(inputs.run.ambiguous > before_.run.ambiguous, health_t::FAULT_AMBIGUOUS);
  set(!inputs.publish.bus_problem.empty(), health_t::FAULT_BUS);
  set(!inputs.publish.record_problem.empty(), health_t::FAULT_RECORD);
  set(inputs.publish.not_finite > before_.publish.not_finite, health_t::FAULT_NOT_FINITE);
  set(inputs.calibrations_refused > before_.calibrations_refused, health_t::FAULT_CALIBRATION);
  set(inputs.source.lost_images > before_.source.lost_images ||
          inputs.source.dropped_images > before_.source.dropped_images ||
          inputs.source.damaged_messages > before_.source.damaged_messages,
      health_t::FAULT_IMAGES);
  set(inputs.run.right_turn.is_off, health_t::FAULT_MISCALIBRATED);
  return bits;
}

bool HealthReporter::report(const HealthInputs& inputs, Clock::time_point now, health_t& message) {
  const bool second_is_over = now - before_at_ >= 1s;
  std::int64_t bits = faults(inputs);
  if (second_is_over) {
    const double dt_s = std::chrono::duration<double>(now - before_at_).count();
    const auto rate = [dt_s](std::uint64_t count, std::uint64_t count_before) {
      return static_cast<double>(count - count_before) / dt_s;
    };
    capture_rate_hz_ = rate(inputs.pipeline.captured, before_.pipeline.captured);
    publish_rate_hz_ = rate(inputs.pipeline.published, before_.pipeline.published);
    bits |= inputs.pipeline.captured == before_.pipeline.captured ? health_t::FAULT_NO_PAIRS : 0;
    standing_faults_ = bits;
    before_ = inputs;
    before_at_ = now;
  } else {
    bits |= standing_faults_;
    if (capture_rate_hz_ == 0.0 && inputs.pipeline.captured > before_.pipeline.captured) {
      bits &= ~static_cast<std::int64_t>(health_t::FAULT_NO_PAIRS);
    }
  }
  const std::int8_t state = state_of(bits, inputs);
  if (!second_is_over && bits == sent_faults_ && state == sent_state_) {
    return false;
  }
  sent_faults_ = bits;
  sent_state_ = state;
  fill(inputs, bits, message);
  message.state = state;
  message.capture_rate = capture_rate_hz_;
  message.publish_rate = publish_rate_hz_;
  return true;
}

}  // namespace egomod
