// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/stage_thread.hpp"

#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace egomod {
namespace {

void* run_body(void* body) {
  (*static_cast<std::function<void()>*>(body))();
  return nullptr;
}

std::string failure(const std::string& what, int error, const std::string& remedy) {
  return what + ": " + std::generic_category().message(error) + "; " + remedy;
}

}  // namespace

StageThread::StageThread(const ThreadSettings& settings, std::function<void()> body)
    : body_(std::make_unique<std::function<void()>>(std::move(body))) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, run_body, body_.get());
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), "cannot start thread " + settings.name);
  }
  thread_ = thread;
  apply(settings);
}

StageThread::StageThread(StageThread&& other) noexcept
    : body_(std::move(other.body_)),
      thread_(std::exchange(other.thread_, std::nullopt)),
      warning_(std::move(other.warning_)) {}

StageThread::~StageThread() { join(); }

void StageThread::join() {
  if (thread_) {
    pthread_join(*thread_, nullptr);
    thread_.reset();
  }
}

void StageThread::apply(const ThreadSettings& settings) {
  pthread_setname_np(*thread_, settings.name.substr(0, 15).c_str());
  if (settings.fifo_priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = settings.fifo_priority;
    if (const int error = pthread_setschedparam(*thread_, SCHED_FIFO, &parameters); error != 0) {
      warning_ = failure("thread " + settings.name + " runs without real-time priority", error,
                         "raise LimitRTPRIO= of the service or `ulimit -r`");
    }
  }
  if (settings.cpu >= 0) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(static_cast<std::size_t>(settings.cpu), &cpus);
    if (const int error = pthread_setaffinity_np(*thread_, sizeof cpus, &cpus); error != 0) {
      warning_ += (warning_.empty() ? "" : "; ") +
                  failure("thread " + settings.name + " is not bound to CPU " +
                              std::to_string(settings.cpu),
                          error, "correct pipeline.cpus");
    }
  }
}

std::string lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    return {};
  }
  return failure("memory is not locked", errno,
                 "raise LimitMEMLOCK= of the service or `ulimit -l`");
}

}  // namespace egomod
