// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/frame_ring.hpp"

namespace egomod {

bool FrameRing::push(Frame* frame) {
  for (;;) {
    const std::uint32_t seen = popped_.now();
    if (closed_.load()) {
      return false;
    }
    if (queue_.push(frame)) {
      pushed_.raise();
      return true;
    }
    popped_.wait(seen);
  }
}

Frame* FrameRing::try_pop() {
  Frame* frame = nullptr;
  if (queue_.pop(frame)) {
    popped_.raise();
  }
  return frame;
}

Frame* FrameRing::pop() {
  for (;;) {
    const std::uint32_t seen = pushed_.now();
    if (Frame* frame = try_pop()) {
      return frame;
    }
    if (closed_.load()) {
      return try_pop();  // the last push may have come between the first look and the close
    }
    pushed_.wait(seen);
  }
}

void FrameRing::close() {
  closed_.store(true);
  pushed_.raise();
  popped_.raise();
}

FramePool::FramePool(std::size_t slots) : frames_(slots), published_(slots), discarded_(slots) {
  for (Frame& frame : frames_) {
    published_.push(&frame);
  }
}

Frame* FramePool::try_pop() {
  Frame* frame = nullptr;
  return discarded_.pop(frame) || published_.pop(frame) ? frame : nullptr;
}

Frame* FramePool::pop() {
  for (;;) {
    const std::uint32_t seen = returned_.now();
    if (closed_.load()) {
      return nullptr;
    }
    if (Frame* frame = try_pop()) {
      return frame;
    }
    returned_.wait(seen);
  }
}

bool FramePool::push(Frame* frame) {
  published_.push(frame);
  returned_.raise();
  return true;
}

void FramePool::discard(Frame* frame) {
  discarded_.push(frame);
  returned_.raise();
}

void FramePool::close() {
  closed_.store(true);
  returned_.raise();
}

}  // namespace egomod
