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
  std::fputs(command.text.c_str(), refused ? stderr : stdout);
  return command.exit_code;
}
