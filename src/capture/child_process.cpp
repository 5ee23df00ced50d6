// SPDX-License-Identifier: Apache-2.0
#include "capture/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

namespace egomod {
namespace {

constexpr std::size_t kKeptBytes = 4096;

void require(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

// What posix_spawn does between fork and exec; its calls fail only for want of memory.
class SpawnPlan {
 public:
  SpawnPlan() {
    require(posix_spawn_file_actions_init(&actions), "posix_spawn_file_actions_init");
    require(posix_spawnattr_init(&attributes), "posix_spawnattr_init");
    sigset_t none;
    sigemptyset(&none);
    sigset_t all;
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  void give(int fd, int fd_in_child) {
    require(posix_spawn_file_actions_adddup2(&actions, fd, fd_in_child), "dup2");
  }

  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

std::string ending(int status) {
  if (WIFSIGNALED(status)) {
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" +
           strsignal(WTERMSIG(status)) + ")";
  }
  return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

bool ends_within(pid_t pid, std::chrono::milliseconds patience) {
  // Not pidfd_open(): the header of glibc 2.36 forgets that C++ may include it.
  const OwnedFd process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  pollfd wait{process.get(), POLLIN, 0};
  return poll(&wait, 1, static_cast<int>(patience.count())) > 0;
}

}  // namespace

OwnedFd::OwnedFd(OwnedFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

OwnedFd& OwnedFd::operator=(OwnedFd&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

OwnedFd::~OwnedFd() { reset(); }

void OwnedFd::reset() {
  if (fd_ >= 0) close(std::exchange(fd_, -1));
}

ChildProcess::ChildProcess(const std::filesystem::path& program, std::vector<std::string> arguments,
                           int socket_in_child) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    require(errno, "socketpair");
  }
  socket_ = OwnedFd(ends[0]);
  const OwnedFd its_socket(ends[1]);
  if (pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0) require(errno, "pipe2");
  errors_ = OwnedFd(ends[0]);
  const OwnedFd its_errors(ends[1]);
  fcntl(its_errors.get(), F_SETFL, 0);  // it waits while the pipe is full
  SpawnPlan plan;
  // stderr first: the socket's place may be where the pipe is.
  plan.give(its_errors.get(), STDERR_FILENO);
  plan.give(its_socket.get(), socket_in_child);
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  require(
      posix_spawn(&pid_, program.c_str(), &plan.actions, &plan.attributes, argv.data(), environ),
      program.c_str());
}

ChildProcess::~ChildProcess() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool ChildProcess::read_errors() {
  std::array<char, 1024> buffer{};
  ssize_t count = 0;
  while ((count = read(errors_.get(), buffer.data(), buffer.size())) > 0) {
    said_.append(buffer.data(), static_cast<std::size_t>(count));
    if (said_.size() > kKeptBytes) said_.erase(0, said_.size() - kKeptBytes);
  }
  return count != 0;
}

std::string ChildProcess::last_words() const {
  const std::size_t end = said_.rfind('\n');
  if (end == std::string::npos) return {};
  const std::size_t last = said_.find_last_not_of('\n', end);
  if (last == std::string::npos) return {};
  const std::size_t before = said_.rfind('\n', last);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return said_.substr(begin, last + 1 - begin);
}

std::string ChildProcess::end(std::chrono::milliseconds patience) {
  const bool ends = ends_within(pid_, patience);
  if (!ends) kill(pid_, SIGKILL);
  int status = 0;
  waitpid(std::exchange(pid_, -1), &status, 0);
  read_errors();
  return ends ? ending(status) : "had to be killed";
}

}  // namespace egomod
