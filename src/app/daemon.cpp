// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/daemon.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "egomod/app/command_line.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
#include "egomod/pipeline/pipeline.hpp"
#include "egomod/publish/publisher.hpp"
#include "egomod/publish/record_writer.hpp"
#include "logging.hpp"
#include "run_summary.hpp"
#include "service_manager.hpp"
#include "supervisor.hpp"

namespace egomod {
namespace {

using Clock = std::chrono::steady_clock;

PublishTarget target_of(const Config& config, bool live) {
  return {.lcm_url = config.daemon.lcm_url,
          .record = config.daemon.record,
          .record_timing = config.daemon.record_timing,
          .live = live};
}

PipelineEnd run(Pipeline& pipeline, bool single_thread) {
  if (single_thread) {
    return pipeline.run_single_thread();
  }
  pipeline.start();
  for (const std::string& warning : pipeline.warnings()) {
    spdlog::warn("{}", warning);
  }
  return pipeline.join();
}

// The stages that this run is made of, and what becomes of a frame in each.
class Stages {
 public:
  Stages(const Config& config, bool live)
      : tracker_(config.features),
        estimator_(config.egomotion),
        detector_(config.moving_objects),
        publisher_(config.publish, target_of(config, live)) {}

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

// Opening the record empties it.
void refuse_record_over_source(const DaemonConfig& daemon) {
  constexpr std::string_view kLog = "log:";
  if (daemon.record.empty() || !daemon.source.starts_with(kLog)) {
    return;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(daemon.source.substr(kLog.size()), daemon.record, ignored)) {
    throw RecordError("record " + daemon.record +
                      ": is the log that is read, and would be overwritten; name another file");
  }
}

int run_to_the_end(const Config& config, bool quiet) {
  const auto begin = Clock::now();
  refuse_record_over_source(config.daemon);
  const auto source = open_source(config.daemon.source, config.capture, config.daemon.rig,
                                  config.daemon.lcm_url, config.pipeline.realtime);
  const bool live = config.pipeline.realtime || !source->is_replay();
  Stages stages(config, live);
  Pipeline pipeline(config.pipeline, *source, stages.functions());
  PipelineEnd end = PipelineEnd::kStopped;
  {
    Supervisor supervisor({.source = *source,
                           .pipeline = pipeline,
                           .publisher = stages.publisher(),
                           .summary = stages.summary(),
                           .show_progress = !quiet && source->is_replay(),
                           .repeat_s = config.logging.repeat_s,
                           .lcm_url = config.daemon.lcm_url});
    end = run(pipeline, config.pipeline.single_thread);
    if (end == PipelineEnd::kFailed) {
      supervisor.set_failed();
    }
  }
  stages.publisher().close();
  if (!quiet && source->is_replay()) {
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - begin).count();
    fmt::print("{}", summary_text(stages.summary().figures(), pipeline.statistics(), elapsed_s,
                                  config.daemon.record));
  }
  if (end == PipelineEnd::kFailed) {
    spdlog::error("{}; {} pairs before it were processed", pipeline.error(), pipeline.published());
    return kExitFailure;
  }
  return kExitSuccess;
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
