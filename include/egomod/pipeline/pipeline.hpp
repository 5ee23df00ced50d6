// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "egomod/capture/frame_source.hpp"
#include "egomod/core/frame.hpp"
#include "egomod/pipeline/frame_ring.hpp"
#include "egomod/pipeline/pacer.hpp"
#include "egomod/pipeline/pipeline_config.hpp"
#include "egomod/pipeline/pipeline_statistics.hpp"
#include "egomod/pipeline/stage_thread.hpp"

namespace egomod {

// What each stage does with a frame: reads the members before its own, refills its own.
struct PipelineStages {
  std::function<void(Frame&)> features;
  std::function<void(Frame&)> egomotion;
  std::function<void(Frame&)> moving_objects;
  std::function<void(Frame&)> publish;
};

enum class PipelineEnd {
  kSourceEnded,
  kStopped,
  kFailed,  // Pipeline::error() says why; what came before the failure has been published
};

// The live view of an edge: the newest frame that waits, older ones go back to the pool and are
// counted. Threads: one consumer.
class NewestOf {
 public:
  NewestOf(FrameRing& ring, FramePool& pool, PipelineCounters& counters)
      : ring_(ring), pool_(pool), counters_(counters) {}

  [[nodiscard]] Frame* pop();
  void close() { ring_.close(); }

 private:
  FrameRing& ring_;
  FramePool& pool_;
  PipelineCounters& counters_;
  bool broken_after_last_ = false;  // the stream broke after the frame that was taken last
};

// capture -> features -> egomotion -> moving objects -> publish, one thread a stage (or, with
// `single_thread`, one for all). Live, the newest pair wins before features; in a replay the
// producer waits. One object is one run. Threads: `request_stop`, `statistics` and `published` from
// any; the rest one caller.
class Pipeline {
 public:
  // `source` must outlive the pipeline.
  Pipeline(const PipelineConfig& config, FrameSource& source, PipelineStages stages);
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;
  ~Pipeline();

  void start();
  // No further pair is taken; those in flight are finished.
  void request_stop() { stop_.request_stop(); }
  // Joins the stages in pipeline order.
  PipelineEnd join();

  [[nodiscard]] const std::string& error() const { return error_; }
  // Scheduling asked for and not permitted. Valid after `start`.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  [[nodiscard]] PipelineStatistics statistics() const { return counters_.snapshot(); }
  [[nodiscard]] std::uint64_t published() const { return counters_.published(); }
  // The newest pair wins, instead of every pair.
  [[nodiscard]] bool is_live() const { return live_; }

 private:
  // False: nothing to hand on, the stage ends.
  using Work = std::function<bool(Frame&)>;

  void launch_stages();
  void launch_single_thread();
  template <typename In, typename Out>
  void launch(Stage stage, In& in, Out& out);
  template <typename In, typename Out>
  void loop(Stage stage, In& in, Out& out);
  void loop_over_all_stages();
  // Times the stage's work on a frame; an exception ends the run and is kept as its failure.
  [[nodiscard]] bool work_on(Stage stage, Frame& frame);
  [[nodiscard]] bool capture(Frame& frame);
  void fail(Stage stage, const std::string& what);
  [[nodiscard]] PipelineEnd conclude();

  PipelineConfig config_;
  FrameSource& source_;
  std::array<Work, kStageCount> work_;
  bool live_;
  Pacer pacer_;
  PipelineCounters counters_;

  FramePool pool_;
  FrameRing captured_;
  NewestOf newest_captured_;
  FrameRing tracked_;
  FrameRing located_;
  FrameRing detected_;
  std::vector<StageThread> threads_;

  std::array<std::string, kStageCount> failures_;  // each written by its stage, read after join
  bool source_ended_ = false;                      // written by capture, read after join
  std::string error_;
  std::vector<std::string> warnings_;

  std::stop_source stop_;
  std::stop_callback<std::function<void()>> close_pool_on_stop_;
};

// "2,3,4,5,5" or "2": the CPU of each stage; -1 where any will do. Throws std::invalid_argument.
[[nodiscard]] std::array<int, kStageCount> parse_cpus(const std::string& cpus);

}  // namespace egomod
