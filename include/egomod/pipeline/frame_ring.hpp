// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "egomod/core/frame.hpp"

namespace egomod {

inline constexpr std::size_t kCacheLineBytes = 64;

// A counter that a waiting thread sleeps on. Read `now()`, look for work, then `wait` with what was
// read: work that arrived in between has changed the counter, so no wake-up is lost.
class WakeUp {
 public:
  [[nodiscard]] std::uint32_t now() const { return count_.load(); }
  void raise() {
    count_.fetch_add(1);
    count_.notify_all();
  }
  void wait(std::uint32_t seen) const { count_.wait(seen); }

 private:
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> count_{0};
};

// One edge of the pipeline: frames in order from one stage to the next. A frame in the ring belongs
// to the ring. Either side may close it; what was pushed before can still be popped.
// Threads: one producer, one consumer.
class FrameRing {
 public:
  explicit FrameRing(std::size_t capacity) : queue_(capacity) {}

  // Waits while the ring is full. False: closed, the frame stays with the caller.
  [[nodiscard]] bool push(Frame* frame);
  // Waits while the ring is empty. nullptr: closed and empty.
  [[nodiscard]] Frame* pop();
  // nullptr: empty at this moment.
  [[nodiscard]] Frame* try_pop();
  // Threads: any.
  void close();

 private:
  boost::lockfree::spsc_queue<Frame*> queue_;
  WakeUp pushed_;
  WakeUp popped_;
  std::atomic<bool> closed_{false};
};

// The fixed set of frames, and the two rings by which they come back to capture: from publish, and
// from features those that a newer pair has overtaken.
// Threads: `pop` capture only, `push` publish only, `discard` features only, `close` any.
class FramePool {
 public:
  explicit FramePool(std::size_t slots);

  // Waits for a frame. nullptr: closed.
  [[nodiscard]] Frame* pop();
  // A frame always finds its place; true, as FrameRing::push.
  [[nodiscard]] bool push(Frame* frame);
  void discard(Frame* frame);
  void close();

 private:
  [[nodiscard]] Frame* try_pop();

  std::vector<Frame> frames_;
  boost::lockfree::spsc_queue<Frame*> published_;
  boost::lockfree::spsc_queue<Frame*> discarded_;
  WakeUp returned_;
  std::atomic<bool> closed_{false};
};

}  // namespace egomod
