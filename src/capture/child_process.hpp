// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace egomod {

// A descriptor that is closed with its owner.
class OwnedFd {
 public:
  explicit OwnedFd(int fd = -1) : fd_(fd) {}
  OwnedFd(OwnedFd&& other) noexcept;
  OwnedFd& operator=(OwnedFd&& other) noexcept;
  ~OwnedFd();

  [[nodiscard]] int get() const { return fd_; }
  void reset();

 private:
  int fd_;
};

// A program that finds one end of a Unix socket (SOCK_SEQPACKET) at a descriptor of its own. What
// it writes to stderr is kept, the last of it. It gets no signals from the terminal, and does not
// outlive this object. Threads: one caller.
class ChildProcess {
 public:
  // Throws std::system_error.
  ChildProcess(const std::filesystem::path& program, std::vector<std::string> arguments,
               int socket_in_child);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  [[nodiscard]] int socket() const { return socket_.get(); }
  [[nodiscard]] int errors() const { return errors_.get(); }
  // Takes what there is on stderr, without waiting. False: there will be no more.
  bool read_errors();
  // The last whole line of stderr that is not empty.
  [[nodiscard]] std::string last_words() const;
  // Waits for its end, but not longer than `patience`; then puts an end to it. How it ended.
  [[nodiscard]] std::string end(std::chrono::milliseconds patience);

 private:
  pid_t pid_ = -1;
  OwnedFd socket_;
  OwnedFd errors_;
  std::string said_;
};

}  // namespace egomod
