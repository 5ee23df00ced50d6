// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <numeric>
#include <semaphore>
#include <stdexcept>
#include <thread>
#include <vector>

#include "fake_source.hpp"

namespace egomod {
namespace {

using std::chrono::milliseconds;

// Stages whose results depend on every stage before them and on all frames so far, and that write
// what comes out at the end to `published`.
struct FakeStages {
  std::vector<std::uint64_t> published;
  std::uint64_t state = 1;

  PipelineStages stages() {
    return {
        .features = [](Frame& f) { f.tracks.sequence = f.pair.sequence * 3; },
        .egomotion =
            [this](Frame& f) {
              state = state * 6364136223846793005U + f.tracks.sequence;
              f.motion.sequence = state;
            },
        .moving_objects = [](Frame& f) { f.objects.sequence = f.motion.sequence ^ 5U; },
        .publish = [this](Frame& f) { published.push_back(f.objects.sequence); },
    };
  }
};

PipelineStages counting(std::vector<std::uint64_t>& published) {
  const auto nothing = [](Frame&) {};
  return {nothing, nothing, nothing,
          [&](Frame& frame) { published.push_back(frame.pair.sequence); }};
}

std::vector<std::uint64_t> numbers(std::uint64_t count) {
  std::vector<std::uint64_t> result(count);
  std::iota(result.begin(), result.end(), 0U);
  return result;
}

TEST(Pipeline, one_thread_and_five_give_the_same_sequence) {
  FakeStages one;
  FakeStages five;
  FakeSource source_one({.pairs = 500});
  FakeSource source_five({.pairs = 500});
  Pipeline pipeline_one({.single_thread = true}, source_one, one.stages());
  Pipeline pipeline_five({}, source_five, five.stages());
  pipeline_one.start();
  pipeline_five.start();
  EXPECT_EQ(pipeline_one.join(), PipelineEnd::kSourceEnded);
  EXPECT_EQ(pipeline_five.join(), PipelineEnd::kSourceEnded);
  EXPECT_EQ(one.published.size(), 500U);
  EXPECT_EQ(one.published, five.published);
}

TEST(Pipeline, a_replay_waits_for_a_slow_stage_and_loses_nothing) {
  std::vector<std::uint64_t> published;
  PipelineStages stages = counting(published);
  stages.moving_objects = [](Frame& frame) {
    if (frame.pair.sequence % 10 == 0) {
      std::this_thread::sleep_for(milliseconds(3));
    }
  };
  FakeSource source({.pairs = 200});
  Pipeline pipeline({.slots = 6}, source, stages);
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kSourceEnded);
  EXPECT_EQ(published, numbers(200));
  EXPECT_EQ(pipeline.statistics().dropped, 0U);
  EXPECT_EQ(pipeline.statistics().published, 200U);
  EXPECT_EQ(pipeline.statistics().stages[1].count, 200U);
}

// A live camera whose pairs 1, 2, ... come while features is still busy with pair 0.
class BusyFeatures : public ::testing::Test {
 protected:
  void run(std::uint64_t pairs, const std::function<void(StereoPair&)>& change) {
    FakeSource source({.pairs = pairs,
                       .after = SourceState::kPair,
                       .replay = false,
                       .change = [&](StereoPair& pair) {
                         change(pair);
                         if (pair.sequence == 1) {
                           busy_.acquire();
                         }
                       }});
    PipelineStages stages = counting(published_);
    stages.features = [this](Frame& frame) {
      if (frame.pair.sequence == 0) {
        busy_.release();
        go_.acquire();
      }
    };
    stages.egomotion = [this](Frame& frame) { broken_ = broken_ || frame.pair.discontinuity; };
    Pipeline pipeline({}, source, stages);
    pipeline.start();
    wait_until([&] { return pipeline.statistics().captured == pairs; });
    std::this_thread::sleep_for(milliseconds(20));  // the last pair is counted before it is pushed
    go_.release();
    wait_until([&] { return pipeline.published() == 2; });
    pipeline.request_stop();
    EXPECT_EQ(pipeline.join(), PipelineEnd::kStopped);
    statistics_ = pipeline.statistics();
  }

  std::vector<std::uint64_t> published_;
  bool broken_ = false;
  PipelineStatistics statistics_;

 private:
  static void wait_until(const std::function<bool()>& condition) {
    while (!condition()) {
      std::this_thread::sleep_for(milliseconds(1));
    }
  }

  std::binary_semaphore busy_{0};
  std::binary_semaphore go_{0};
};

TEST_F(BusyFeatures, takes_the_newest_pair_next_and_each_overtaken_one_is_counted) {
  run(6, [](StereoPair& pair) { pair.discontinuity = pair.sequence == 3; });
  EXPECT_EQ(published_, (std::vector<std::uint64_t>{0, 5}));
  EXPECT_EQ(statistics_.dropped, 4U);
  EXPECT_EQ(statistics_.dropped_usable, 4U);
  EXPECT_TRUE(broken_) << "the break of the stream got lost with an overtaken pair";
}

TEST_F(BusyFeatures, takes_no_skipped_pair_in_place_of_one_to_work_on) {
  run(5, [](StereoPair& pair) {
    const bool kept = pair.sequence == 0 || pair.sequence == 2;
    pair.status = kept ? PairStatus::kOk : PairStatus::kSkipped;
  });
  EXPECT_EQ(published_, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(statistics_.dropped, 3U);
  EXPECT_EQ(statistics_.dropped_usable, 0U);
  EXPECT_EQ(statistics_.skipped, 3U);
}

TEST(Pipeline, live_a_stage_slower_than_the_camera_drops_exactly_what_it_does_not_publish) {
  std::vector<std::uint64_t> published;
  PipelineStages stages = counting(published);
  stages.features = [](Frame&) { std::this_thread::sleep_for(milliseconds(5)); };
  FakeSource source({.pairs = 200, .replay = false, .change = [](StereoPair&) {
                       std::this_thread::sleep_for(milliseconds(1));
                     }});
  Pipeline pipeline({}, source, stages);
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kSourceEnded);
  EXPECT_TRUE(std::is_sorted(published.begin(), published.end()));
  EXPECT_EQ(published.back(), 199U);
  EXPECT_GT(pipeline.statistics().dropped, 0U);
  EXPECT_EQ(pipeline.statistics().dropped + published.size(), 200U);
}

TEST(Pipeline, starts_and_stops_a_hundred_times) {
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint64_t> published;
    FakeSource source({.pairs = 1'000'000, .replay = i % 2 == 0});
    Pipeline pipeline({.slots = 6}, source, counting(published));
    pipeline.start();
    if (i % 3 == 0) {
      std::this_thread::sleep_for(std::chrono::microseconds(100 * i));
    }
    pipeline.request_stop();
    ASSERT_EQ(pipeline.join(), PipelineEnd::kStopped);
    const PipelineStatistics statistics = pipeline.statistics();
    ASSERT_EQ(statistics.captured, statistics.published + statistics.dropped);
  }
}

TEST(Pipeline, stops_while_the_source_blocks_before_the_first_pair) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 0, .after = SourceState::kPair, .replay = false});
  Pipeline pipeline({}, source, counting(published));
  pipeline.start();
  std::this_thread::sleep_for(milliseconds(10));
  pipeline.request_stop();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kStopped);
  EXPECT_TRUE(published.empty());
}

TEST(Pipeline, stops_while_every_ring_is_full_and_finishes_what_is_under_way) {
  std::vector<std::uint64_t> published;
  std::binary_semaphore go(0);
  PipelineStages stages = counting(published);
  stages.publish = [&, first = true](Frame& frame) mutable {
    if (std::exchange(first, false)) {
      go.acquire();
    }
    published.push_back(frame.pair.sequence);
  };
  FakeSource source({.pairs = 1000});
  Pipeline pipeline({}, source, stages);
  pipeline.start();
  std::this_thread::sleep_for(milliseconds(30));
  pipeline.request_stop();
  go.release();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kStopped);
  EXPECT_EQ(published, numbers(published.size()));
  EXPECT_EQ(published.size(), pipeline.statistics().captured);
}

TEST(Pipeline, is_stopped_by_its_destructor) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 1'000'000});
  Pipeline pipeline({}, source, counting(published));
  pipeline.start();
}

TEST(Pipeline, an_exception_in_any_stage_ends_the_run_and_is_reported) {
  for (int failing = 0; failing < 4; ++failing) {
    for (const bool single_thread : {false, true}) {
      std::vector<std::uint64_t> published;
      PipelineStages stages = counting(published);
      const auto publish = stages.publish;
      const auto fail = [&](Frame& frame) {
        if (frame.pair.sequence == 20) {
          throw std::runtime_error("lens cap");
        }
        if (failing == 3) {
          publish(frame);
        }
      };
      std::array work{&stages.features, &stages.egomotion, &stages.moving_objects, &stages.publish};
      *work[static_cast<std::size_t>(failing)] = fail;
      FakeSource source({.pairs = 1'000'000});
      Pipeline pipeline({.single_thread = single_thread}, source, stages);
      pipeline.start();
      EXPECT_EQ(pipeline.join(), PipelineEnd::kFailed);
      const Stage stage = static_cast<Stage>(failing + 1);
      EXPECT_EQ(pipeline.error(), std::string(name(stage)) + ": lens cap");
      EXPECT_EQ(published, numbers(20)) << "what came before the failure is published";
    }
  }
}

TEST(Pipeline, a_source_that_fails_midway_is_reported_after_all_pairs_before_it) {
  for (const bool single_thread : {false, true}) {
    std::vector<std::uint64_t> published;
    FakeSource source({.pairs = 100, .after = SourceState::kFailed});
    Pipeline pipeline({.single_thread = single_thread}, source, counting(published));
    pipeline.start();
    EXPECT_EQ(pipeline.join(), PipelineEnd::kFailed);
    EXPECT_EQ(pipeline.error(), "pair 100: cannot be read");
    EXPECT_EQ(published, numbers(100));
  }
}

TEST(Pipeline, a_single_thread_stops_between_two_pairs) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 1'000'000});
  Pipeline* running = nullptr;
  PipelineStages stages = counting(published);
  stages.features = [&](Frame& frame) {
    if (frame.pair.sequence == 10) {
      running->request_stop();
    }
  };
  Pipeline pipeline({.single_thread = true}, source, stages);
  running = &pipeline;
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kStopped);
  EXPECT_EQ(published, numbers(11));
}

TEST(Pipeline, realtime_paces_a_replay_by_its_exposure_times) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 11, .interval = milliseconds(10)});
  Pipeline pipeline({.realtime = true}, source, counting(published));
  const auto begin = std::chrono::steady_clock::now();
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kSourceEnded);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(100));
  EXPECT_EQ(published.back(), 10U);
}

TEST(Pipeline, realtime_leaves_the_pace_to_a_source_that_waits_for_its_pairs) {
  std::vector<std::uint64_t> published;
  Nanoseconds arrival{0};
  FakeSource source({.pairs = 2,
                     .waits_for_arrival = true,
                     .interval = std::chrono::hours(1),
                     .change = [](StereoPair& pair) { pair.arrival = monotonic_now(); }});
  PipelineStages stages = counting(published);
  stages.features = [&](Frame& frame) {
    arrival = frame.pair.arrival;
    EXPECT_EQ(frame.times[0].start, arrival) << "waiting is no work";
  };
  Pipeline pipeline({.single_thread = true, .realtime = true}, source, stages);
  EXPECT_TRUE(pipeline.is_live());
  const Nanoseconds begin = monotonic_now();
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kSourceEnded);
  EXPECT_EQ(published, numbers(2));
  EXPECT_GT(arrival, begin);
}

TEST(Pipeline, a_paced_replay_stops_at_once) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 10, .interval = std::chrono::hours(1)});
  Pipeline pipeline({.realtime = true}, source, counting(published));
  pipeline.start();
  std::this_thread::sleep_for(milliseconds(10));
  pipeline.request_stop();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kStopped);
}

TEST(Pipeline, counts_rejected_pairs_and_the_largest_skew) {
  std::vector<std::uint64_t> published;
  FakeSource source({.pairs = 10, .change = [](StereoPair& pair) {
                       pair.status = pair.sequence == 4 ? PairStatus::kRejected : PairStatus::kOk;
                       pair.fault = pair.sequence == 4 ? PairFault::kSkew : PairFault::kNone;
                       pair.right_exposure =
                           pair.exposure - (pair.sequence == 4   ? milliseconds(70)
                                            : pair.sequence == 7 ? milliseconds(9)
                                                                 : milliseconds(1));
                     }});
  Pipeline pipeline({.single_thread = true}, source, counting(published));
  pipeline.start();
  EXPECT_EQ(pipeline.join(), PipelineEnd::kSourceEnded);
  const PipelineStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.rejected, 1U);
  EXPECT_EQ(statistics.rejected_by[static_cast<std::size_t>(PairFault::kSkew)], 1U);
  EXPECT_EQ(statistics.least_rejected_skew, milliseconds(70));
  EXPECT_EQ(statistics.last_skew, milliseconds(-1));
  EXPECT_EQ(statistics.max_skew, milliseconds(9));
  EXPECT_EQ(statistics.total.count, 9U);
}

TEST(Pipeline, two_at_once_do_not_share_anything) {
  FakeStages a;
  FakeStages b;
  FakeSource source_a({.pairs = 300});
  FakeSource source_b({.pairs = 300});
  Pipeline pipeline_a({}, source_a, a.stages());
  Pipeline pipeline_b({}, source_b, b.stages());
  pipeline_a.start();
  pipeline_b.start();
  pipeline_a.join();
  pipeline_b.join();
  EXPECT_EQ(a.published, b.published);
}

}  // namespace
}  // namespace egomod
