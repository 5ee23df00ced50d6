// SPDX-License-Identifier: Apache-2.0
#include "gnuplot.hpp"

#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace egomod::gnuplot {

void run(const std::string& folder, const std::string& script) {
  std::string program = "gnuplot";
  std::string file = script;
  std::array<char*, 3> arguments{program.data(), file.data(), nullptr};
  // Not by gnuplot's own cd, for which the folder's name would have to be quoted.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) {
    throw GnuplotError("gnuplot is not installed, no figure drawn: apt-get install gnuplot-nox");
  }
  if (error != 0) {
    throw GnuplotError(std::string("gnuplot cannot be started: ") + std::strerror(error));
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw GnuplotError("gnuplot failed on " + folder + "/" + script);
  }
}

}  // namespace egomod::gnuplot
