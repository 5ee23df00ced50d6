// SPDX-License-Identifier: Apache-2.0
// The daemon: stereo pairs in; pose, velocity and moving objects out.
#include <cstdio>

#include "egomod/app/command_line.hpp"
#include "egomod/app/daemon.hpp"

int main(int argc, char** argv) {
  egomod::block_signals();
  const egomod::Command command = egomod::parse_command_line(argc, argv);
  if (command.action == egomod::Command::Action::kRun) {
    return egomod::run_daemon(command.config, command.quiet);
  }
  const bool refused = command.action == egomod::Command::Action::kRefuse;
  std::FILE* const out = refused ? stderr : stdout;
  if (std::fputs(command.text.c_str(), out) < 0 || std::fflush(out) != 0) {
    std::perror("egomodd: standard output");
    return egomod::kExitFailure;
  }
  return command.exit_code;
}
