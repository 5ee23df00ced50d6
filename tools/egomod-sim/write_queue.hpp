// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace egomod::sim {

// Threads that write files while the next images are rendered: compressing a noisy image takes as
// long as rendering it. Threads: one caller.
class WriteQueue {
 public:
  WriteQueue();
  WriteQueue(const WriteQueue&) = delete;
  WriteQueue& operator=(const WriteQueue&) = delete;
  ~WriteQueue();

  // Waits while too many wait already; throws what an earlier job threw.
  void push(std::function<void()> job);
  // All jobs are done. Throws what one of them threw.
  void finish();

 private:
  void work();
  void rethrow();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  int running_ = 0;
  bool is_over_ = false;
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last: they use the rest
};

}  // namespace egomod::sim
