// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/pipeline.hpp"

#include <algorithm>
#include <charconv>
#include <exception>
#include <stdexcept>
#include <utility>

namespace egomod {
namespace {

// Stages after features press back at once: what waits longer there is only older.
constexpr std::size_t kLaterEdgeFrames = 1;

std::size_t index(Stage stage) { return static_cast<std::size_t>(stage); }

std::function<bool(Frame&)> always(std::function<void(Frame&)> work) {
  return [work = std::move(work)](Frame& frame) {
    work(frame);
    return true;
  };
}

}  // namespace

Pipeline::Pipeline(const PipelineConfig& config, FrameSource& source, PipelineStages stages)
    : config_(config),
      source_(source),
      work_{[this](Frame& frame) { return capture(frame); }, always(std::move(stages.features)),
            always(std::move(stages.egomotion)), always(std::move(stages.moving_objects)),
            always(std::move(stages.publish))},
      live_(config.realtime || !source.is_replay()),
      pool_(static_cast<std::size_t>(config.slots)),
      captured_(static_cast<std::size_t>(config.slots)),
      newest_captured_(captured_, pool_, counters_),
      tracked_(kLaterEdgeFrames),
      located_(kLaterEdgeFrames),
      detected_(kLaterEdgeFrames),
      close_pool_on_stop_(stop_.get_token(), [this] { pool_.close(); }) {}

Pipeline::~Pipeline() {
  request_stop();
  join();
}

void Pipeline::start() {
  if (config_.lock_memory) {
    warnings_.push_back(lock_memory());
  }
  try {
    config_.single_thread ? launch_single_thread() : launch_stages();
  } catch (...) {  // no thread to be had: those that run must not wait for those that do not
    request_stop();
    for (FrameRing* ring : {&captured_, &tracked_, &located_, &detected_}) {
      ring->close();
    }
    join();
    throw;
  }
  std::erase(warnings_, std::string());
}

// The wiring: each stage takes a frame from one edge, works on it in place, and gives it to the
// next; the pool closes the circle.
void Pipeline::launch_stages() {
  launch(Stage::kCapture, pool_, captured_);
  if (live_) {
    launch(Stage::kFeatures, newest_captured_, tracked_);
  } else {
    launch(Stage::kFeatures, captured_, tracked_);
  }
  launch(Stage::kEgomotion, tracked_, located_);
  launch(Stage::kMovingObjects, located_, detected_);
  launch(Stage::kPublish, detected_, pool_);
}

template <typename In, typename Out>
void Pipeline::launch(Stage stage, In& in, Out& out) {
  const int earlier_stages = static_cast<int>(index(stage));
  const int priority = config_.realtime_priority;
  const ThreadSettings settings{
      .name = name(stage),
      .fifo_priority = priority > 0 ? std::max(1, priority - earlier_stages) : 0,
      .cpu = parse_cpus(config_.cpus)[index(stage)]};
  threads_.emplace_back(settings, [this, stage, &in, &out] { loop(stage, in, out); });
  warnings_.push_back(threads_.back().warning());
}

// Closing both edges at the end lets the stages after this one finish what is under way, and those
// before it end as well when it is this one that failed.
template <typename In, typename Out>
void Pipeline::loop(Stage stage, In& in, Out& out) {
  while (Frame* frame = in.pop()) {
    if (!work_on(stage, *frame) || !out.push(frame)) {
      break;
    }
  }
  in.close();
  out.close();
}

void Pipeline::launch_single_thread() {
  const ThreadSettings settings{.name = "all stages",
                                .fifo_priority = config_.realtime_priority,
                                .cpu = parse_cpus(config_.cpus)[index(Stage::kCapture)]};
  threads_.emplace_back(settings, [this] { loop_over_all_stages(); });
  warnings_.push_back(threads_.back().warning());
}

void Pipeline::loop_over_all_stages() {
  Frame* frame = pool_.pop();
  const auto work_on_all = [&] {
    for (std::size_t stage = 0; stage < kStageCount; ++stage) {
      if (!work_on(static_cast<Stage>(stage), *frame)) {
        return false;
      }
    }
    return true;
  };
  while (frame != nullptr && !stop_.stop_requested() && work_on_all()) {
  }
}

PipelineEnd Pipeline::join() {
  for (StageThread& thread : threads_) {
    thread.join();
  }
  return conclude();
}

PipelineEnd Pipeline::conclude() {
  const auto failure = std::find_if(failures_.begin(), failures_.end(),
                                    [](const std::string& text) { return !text.empty(); });
  if (failure != failures_.end()) {
    error_ = *failure;
    return PipelineEnd::kFailed;
  }
  return source_ended_ ? PipelineEnd::kSourceEnded : PipelineEnd::kStopped;
}

bool Pipeline::work_on(Stage stage, Frame& frame) {
  StageTime& time = frame.times[index(stage)];
  try {
    time.start = monotonic_now();
    if (!work_[index(stage)](frame)) {
      return false;
    }
    if (stage != Stage::kCapture) {
      time.end = monotonic_now();
    }
    counters_.count_time(stage, time);
    if (stage == Stage::kPublish) {
      counters_.count_published(frame);
    }
    return true;
  } catch (const std::exception& exception) {
    fail(stage, std::string(name(stage)) + ": " + exception.what());
  } catch (...) {
    fail(stage, std::string(name(stage)) + ": unknown exception");
  }
  return false;
}

// Where the source sleeps until the pair arrives, its work begins then. From a disk the pair comes
// when it is asked for: the wait for its time comes after the work, and it arrives at the end.
bool Pipeline::capture(Frame& frame) {
  StereoPair& pair = frame.pair;
  const SourceState state = source_.next(pair, stop_.get_token());
  if (state != SourceState::kPair) {
    source_ended_ = state == SourceState::kEnd;
    if (state == SourceState::kFailed) {
      failures_[index(Stage::kCapture)] = source_.error();
    }
    return false;
  }
  StageTime& time = frame.times[index(Stage::kCapture)];
  time.end = monotonic_now();
  if (source_.waits_for_arrival()) {
    time.start = std::clamp(pair.arrival, time.start, time.end);
  } else {
    if (config_.realtime) {
      pacer_.wait_for(pair.exposure, stop_.get_token());
    }
    pair.arrival = monotonic_now();
  }
  counters_.count_captured(pair);
  return true;
}

void Pipeline::fail(Stage stage, const std::string& what) {
  failures_[index(stage)] = what;
  request_stop();
}

// A pair that cannot be used never overtakes one that can. What broke the stream must not get lost
// with the pair that brought the news.
Frame* NewestOf::pop() {
  Frame* newest = ring_.pop();
  if (newest == nullptr) {
    return nullptr;
  }
  bool broken = std::exchange(broken_after_last_, false);
  while (Frame* newer = ring_.try_pop()) {
    const bool overtakes =
        newer->pair.status == PairStatus::kOk || newest->pair.status != PairStatus::kOk;
    if (overtakes) {
      broken = broken || newest->pair.discontinuity;
      std::swap(newest, newer);
    } else {
      broken_after_last_ = broken_after_last_ || newer->pair.discontinuity;
    }
    counters_.count_dropped(newer->pair);
    pool_.discard(newer);
  }
  newest->pair.discontinuity = newest->pair.discontinuity || broken;
  return newest;
}

std::array<int, kStageCount> parse_cpus(const std::string& cpus) {
  std::array<int, kStageCount> result{};
  result.fill(-1);
  std::size_t count = 0;
  const char* const end = cpus.data() + cpus.size();
  for (const char* at = cpus.data(); at < end; ++count) {
    int cpu = -1;
    const auto [after, error] = std::from_chars(at, end, cpu);
    const bool separated = after == end || (*after == ',' && after + 1 != end);
    if (error != std::errc() || !separated || cpu < 0 || cpu > 1023 || count >= kStageCount) {
      throw std::invalid_argument("want one CPU number or " + std::to_string(kStageCount) +
                                  " separated by commas, in the order of the stages, not \"" +
                                  cpus + "\"");
    }
    result[count] = cpu;
    at = after == end ? end : after + 1;
  }
  if (count == 1) {
    result.fill(result[0]);
  } else if (count != 0 && count != kStageCount) {
    throw std::invalid_argument("\"" + cpus + "\" names " + std::to_string(count) +
                                " CPUs; want one, or one for each of the " +
                                std::to_string(kStageCount) + " stages");
  }
  return result;
}

}  // namespace egomod
