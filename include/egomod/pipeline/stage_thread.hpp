// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace egomod {

struct ThreadSettings {
  std::string name;       // as `top -H` shows it, at most 15 characters
  int fifo_priority = 0;  // SCHED_FIFO; 0: as the starting thread
  int cpu = -1;           // -1: any
};

// A joining thread with a small stack, since mlockall locks stacks whole and std::jthread takes no
// size. Scheduling that is not permitted is left out and reported, never fatal.
class StageThread {
 public:
  static constexpr std::size_t kStackBytes = std::size_t{512} * 1024;

  // Throws std::system_error when no thread can be had.
  StageThread(const ThreadSettings& settings, std::function<void()> body);
  StageThread(StageThread&& other) noexcept;
  StageThread& operator=(StageThread&&) = delete;
  ~StageThread();

  void join();
  // What of the settings could not be had, with the remedy; empty: all is as asked.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  void apply(const ThreadSettings& settings);

  std::unique_ptr<std::function<void()>> body_;
  std::optional<pthread_t> thread_;
  std::string warning_;
};

// mlockall(current and future); the warning when it is not permitted, else empty.
[[nodiscard]] std::string lock_memory();

}  // namespace egomod
