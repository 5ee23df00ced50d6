// SPDX-License-Identifier: Apache-2.0
#include "supervisor.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

#include "egomod/app/daemon.hpp"
#include "service_manager.hpp"

namespace egomod {
namespace {

constexpr int kTickMilliseconds = 250;
constexpr int kEnd = -1;

sigset_t taken_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

int checked(int fd, const char* what) {
  if (fd < 0) {
    throw std::system_error(errno, std::generic_category(), what);
  }
  return fd;
}

}  // namespace

void block_signals() {
  const sigset_t signals = taken_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

Supervisor::Supervisor(const Supervised& supervised)
    : supervised_(supervised), warnings_(supervised.repeat_s) {
  if (supervised_.show_progress) {
    progress_.emplace("egomodd", "pairs", supervised_.source.size());
  }
  if (supervised_.pipeline.is_live()) {
    requests_.emplace(supervised_.lcm_url, supervised_.source);
  }
  const sigset_t signals = taken_signals();
  signal_fd_ = checked(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK), "signalfd");
  end_fd_ = checked(eventfd(0, EFD_CLOEXEC), "eventfd");
  thread_.emplace(ThreadSettings{.name = "supervisor"}, [this] { loop(); });
}

Supervisor::~Supervisor() {
  const std::uint64_t one = 1;
  if (write(end_fd_, &one, sizeof one) != sizeof one) {
    spdlog::error("cannot end the supervisor: {}", std::strerror(errno));
  }
  thread_.reset();
  tick();
  notify_service_manager("STOPPING=1");
  if (progress_) {
    progress_->finish(supervised_.pipeline.published());
  }
  close(signal_fd_);
  close(end_fd_);
}

void Supervisor::loop() {
  for (int signal = 0; signal != kEnd; signal = wait_for_signal()) {
    if (signal != 0 && !stopping_) {
      stopping_ = true;
      notify_service_manager("STOPPING=1\nSTATUS=stopping");
      spdlog::info("{}: stopping", strsignal(signal));
      supervised_.pipeline.request_stop();
    }
    tick();
  }
}

int Supervisor::wait_for_signal() {
  std::array<pollfd, 2> fds{{{signal_fd_, POLLIN, 0}, {end_fd_, POLLIN, 0}}};
  if (poll(fds.data(), fds.size(), kTickMilliseconds) <= 0) {
    return 0;
  }
  if (fds[1].revents != 0) {
    return kEnd;
  }
  signalfd_siginfo info{};
  return read(signal_fd_, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
}

void Supervisor::pass_on_warnings() {
  for (const std::string& warning : supervised_.publisher.take_warnings()) {
    warnings_.warn(warning);
  }
  if (requests_) {
    for (const std::string& answer : requests_->handle()) {
      warnings_.warn(answer);
    }
  }
  for (const std::string& warning : supervised_.source.take_warnings()) {
    warnings_.warn(warning);
  }
  if (const std::string notice = supervised_.source.notice(); !notice.empty()) {
    warnings_.warn(notice);
  }
}

void Supervisor::tick() {
  pass_on_warnings();
  const HealthInputs inputs{
      .pipeline = supervised_.pipeline.statistics(),
      .publish = supervised_.publisher.statistics(),
      .run = supervised_.summary.figures(),
      .source = supervised_.source.counters(),
      .calibrations_refused = requests_ ? requests_->calibrations_refused() : 0,
      .stopping = stopping_,
      .failed = failed_};
  if (progress_) {
    progress_->update(inputs.pipeline.published);
  }
  feed_watchdog(inputs.pipeline);
  if (supervised_.pipeline.is_live()) {
    report_health(inputs);
  }
}

// A missing camera is a fault to report, not a reason to be killed: the watchdog goes hungry only
// while pairs are under way and none comes out.
void Supervisor::feed_watchdog(const PipelineStatistics& statistics) {
  if (!ready_ && statistics.published > 0) {
    ready_ = true;
    notify_service_manager("READY=1");
  }
  const bool idle = statistics.captured == statistics.published + statistics.dropped;
  if (idle || statistics.published != published_before_) {
    notify_service_manager("WATCHDOG=1");
  }
  published_before_ = statistics.published;
}

// Of bus and record the publisher has warned already.
void Supervisor::report_health(const HealthInputs& inputs) {
  supervised_.publisher.repeat_calibration();
  if (!health_.report(inputs, HealthReporter::Clock::now(), health_message_)) {
    return;
  }
  supervised_.publisher.publish_health(health_message_);
  std::string status = fmt::format("{:.1f} pairs a second", health_message_.publish_rate);
  for (const std::string& fault : health_message_.faults) {
    if (fault != inputs.publish.bus_problem && fault != inputs.publish.record_problem) {
      warnings_.warn(fault);
    }
    status += "; " + fault;
  }
  notify_service_manager("STATUS=" + status);
}

}  // namespace egomod
