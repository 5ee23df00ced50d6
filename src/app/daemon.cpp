// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/daemon.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <system_error>

#include "egomod/app/command_line.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
#include "egomod/pipeline/pipeline.hpp"
#include "egomod/publish/publisher.hpp"
#include "egomod/publish/record_writer.hpp"
#include "health.hpp"
#include "logging.hpp"
#include "record_check.hpp"
#include "replay_report.hpp"
#include "run_summary.hpp"
#include "service_manager.hpp"
#include "supervisor.hpp"

namespace egomod {
namespace {

using Clock = std::chrono::steady_clock;

// The record of a replay, paced or not, holds only what is the same each time.
PublishTarget target_of(const DaemonConfig& daemon, const BusAddress& bus, bool is_replay,
                        bool is_live) {
  return {.lcm_url = bus,
          .record = daemon.record,
          .record_timing = daemon.record_timing || !is_replay,
          .live = is_live};
}

PipelineEnd run(Pipeline& pipeline) {
  pipeline.start();
  for (const std::string& warning : pipeline.warnings()) {
    spdlog::warn("{}", warning);
  }
  return pipeline.join();
}

// The stages that this run is made of, and what becomes of a frame in each.
class Stages {
 public:
  Stages(const Config& config, const PublishTarget& target)
      : tracker_(config.features),
        estimator_(config.egomotion),
        detector_(config.moving_objects),
        publisher_(config.publish, target) {}

  PipelineStages functions() {
    return {
        .features = [this](Frame& f) { tracker_.track(f.pair, f.tracks); },
        .egomotion = [this](Frame& f) { estimator_.estimate(f.tracks, f.motion); },
        .moving_objects = [this](Frame& f) { detector_.detect(f.tracks, f.motion, f.objects); },
        .publish =
            [this](Frame& f) {
              publisher_.publish(f);
              summary_.add(f);
            },
    };
  }
  Publisher& publisher() { return publisher_; }
  const RunSummary& summary() const { return summary_; }

 private:
  FeatureTracker tracker_;
  EgomotionEstimator estimator_;
  MovingObjectDetector detector_;
  Publisher publisher_;
  RunSummary summary_;
};

// Closes the record. Why the run has failed; empty if it has not.
std::string conclude(const Pipeline& pipeline, PipelineEnd end, bool is_replay,
                     Publisher& publisher) {
  std::string failure;
  if (end == PipelineEnd::kFailed) {
    failure = fmt::format("{}; {} pairs before it were processed", pipeline.error(),
                          pipeline.published());
  }
  try {
    publisher.close();
  } catch (const RecordError& error) {
    failure = failure.empty() ? error.what() : failure;
  }
  if (failure.empty() && is_replay && end == PipelineEnd::kSourceEnded) {
    failure = why_nothing_was_used(pipeline.statistics());
  }
  return failure;
}

void print(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot write to standard output");
  }
}

int run_to_the_end(const Config& config, bool quiet) {
  const auto begin = Clock::now();
  refuse_record_over_inputs(config.daemon);
  const BusAddress bus(config.daemon.lcm_url);
  const auto source = open_source(config.daemon.source, config.capture, config.daemon.rig, bus,
                                  config.pipeline.realtime);
  const bool is_replay = source->is_replay();
  const bool is_live = config.pipeline.realtime || !is_replay;
  Stages stages(config, target_of(config.daemon, bus, is_replay, is_live));
  Pipeline pipeline(config.pipeline, *source, stages.functions());
  PipelineEnd end = PipelineEnd::kStopped;
  spdlog::info("{}", choices_of_machine(config));
  {
    Supervisor supervisor({.source = *source,
                           .pipeline = pipeline,
                           .publisher = stages.publisher(),
                           .summary = stages.summary(),
                           .show_progress = !quiet && is_replay,
                           .repeat_s = config.logging.repeat_s,
                           .lcm_url = bus});
    end = run(pipeline);
    if (end == PipelineEnd::kFailed) {
      supervisor.set_failed();
    }
  }
  const std::string failure = conclude(pipeline, end, is_replay, stages.publisher());
  if (is_replay) {
    for (const std::string& loss :
         losses_of(pipeline.statistics(), stages.publisher().statistics(), source->counters())) {
      spdlog::warn("{}", loss);
    }
    if (const RightCameraTurn turn = stages.summary().figures().right_turn; turn.is_off) {
      spdlog::warn("{}", miscalibration(turn));
    }
  }
  if (!failure.empty()) {
    spdlog::error("{}", failure);
  }
  if (!quiet && is_replay) {
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - begin).count();
    print(summary_text(stages.summary().figures(), pipeline.statistics(), elapsed_s,
                       config.daemon.record));
  }
  return failure.empty() ? kExitSuccess : kExitFailure;
}

}  // namespace

int run_daemon(const Config& config, bool quiet) {
  set_up_logging(config.logging.level);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run_to_the_end(config, quiet);
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    notify_service_manager(std::string("STATUS=failed: ") + error.what());
    return kExitFailure;
  }
}

}  // namespace egomod
