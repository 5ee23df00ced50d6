// SPDX-License-Identifier: Apache-2.0
#include "write_queue.hpp"

#include <algorithm>
#include <utility>

namespace egomod::sim {
namespace {

constexpr std::size_t kMaxWaiting = 8;

}  // namespace

WriteQueue::WriteQueue() : threads_(std::clamp(std::thread::hardware_concurrency(), 1U, 4U)) {
  for (std::jthread& thread : threads_) thread = std::jthread([this] { work(); });
}

WriteQueue::~WriteQueue() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
}

void WriteQueue::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void WriteQueue::push(std::function<void()> job) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return jobs_.size() < kMaxWaiting || error_; });
    rethrow();
    jobs_.push_back(std::move(job));
  }
  changed_.notify_all();
}

void WriteQueue::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty() && running_ == 0; });
  rethrow();
}

void WriteQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return !jobs_.empty() || is_over_; });
    if (jobs_.empty()) return;
    const std::function<void()> job = std::move(jobs_.front());
    jobs_.pop_front();
    ++running_;
    lock.unlock();
    std::exception_ptr error;
    try {
      job();
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    --running_;
    if (error) error_ = error;
    changed_.notify_all();
  }
}

}  // namespace egomod::sim
