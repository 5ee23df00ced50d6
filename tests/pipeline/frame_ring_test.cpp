// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/frame_ring.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>
#include <vector>

namespace egomod {
namespace {

TEST(FrameRing, keeps_the_order_and_loses_nothing_when_both_sides_sleep_in_turn) {
  constexpr std::uint64_t kFrames = 20000;
  std::vector<Frame> frames(kFrames);
  FrameRing ring(2);
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      frames[i].pair.sequence = i;
      ASSERT_TRUE(ring.push(&frames[i]));
    }
    ring.close();
  });
  std::uint64_t expected = 0;
  while (Frame* frame = ring.pop()) {
    ASSERT_EQ(frame->pair.sequence, expected++);
  }
  producer.join();
  EXPECT_EQ(expected, kFrames);
}

TEST(FrameRing, hands_out_what_was_pushed_before_the_close) {
  std::vector<Frame> frames(2);
  FrameRing ring(2);
  ASSERT_TRUE(ring.push(&frames[0]));
  ASSERT_TRUE(ring.push(&frames[1]));
  ring.close();
  EXPECT_EQ(ring.pop(), &frames[0]);
  EXPECT_EQ(ring.pop(), &frames[1]);
  EXPECT_EQ(ring.pop(), nullptr);
  EXPECT_FALSE(ring.push(&frames[0]));
}

TEST(FrameRing, a_close_wakes_a_consumer_of_an_empty_ring) {
  FrameRing ring(2);
  std::thread consumer([&] { EXPECT_EQ(ring.pop(), nullptr); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ring.close();
  consumer.join();
}

TEST(FrameRing, a_close_wakes_a_producer_at_a_full_ring) {
  std::vector<Frame> frames(2);
  FrameRing ring(1);
  ASSERT_TRUE(ring.push(&frames[0]));
  std::thread producer([&] { EXPECT_FALSE(ring.push(&frames[1])); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ring.close();
  producer.join();
}

TEST(FrameRing, a_waiting_consumer_uses_no_processor_time) {
  FrameRing ring(1);
  timespec used{};
  std::thread consumer([&] {
    EXPECT_EQ(ring.pop(), nullptr);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  ring.close();
  consumer.join();
  constexpr std::int64_t kMostUsed_ns = 20'000'000;  // a spinning thread uses ten times as much
  EXPECT_LT(used.tv_sec * 1'000'000'000 + used.tv_nsec, kMostUsed_ns);
}

TEST(FramePool, hands_out_each_frame_once_and_again_after_either_return) {
  FramePool pool(3);
  const std::set<Frame*> frames{pool.pop(), pool.pop(), pool.pop()};
  ASSERT_EQ(frames.size(), 3U);
  ASSERT_EQ(frames.count(nullptr), 0U);
  EXPECT_TRUE(pool.push(*frames.begin()));
  EXPECT_EQ(pool.pop(), *frames.begin());
  pool.discard(*frames.rbegin());
  EXPECT_EQ(pool.pop(), *frames.rbegin());
}

TEST(FramePool, either_return_wakes_capture) {
  FramePool pool(1);
  Frame* frame = pool.pop();
  for (const bool discarded : {false, true}) {
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (discarded) {
        pool.discard(frame);
      } else {
        EXPECT_TRUE(pool.push(frame));
      }
    });
    EXPECT_EQ(pool.pop(), frame);
    other.join();
  }
}

TEST(FramePool, a_close_wakes_capture) {
  FramePool pool(1);
  ASSERT_NE(pool.pop(), nullptr);
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    pool.close();
  });
  EXPECT_EQ(pool.pop(), nullptr);
  other.join();
}

}  // namespace
}  // namespace egomod
