// SPDX-License-Identifier: Apache-2.0
// All of the daemon in a program of one's own.
#include <cstdio>
#include <egomod/app/command_line.hpp>
#include <egomod/app/daemon.hpp>

int main(int argc, char** argv) {
  egomod::block_signals();
  const egomod::Command command = egomod::parse_command_line(argc, argv);
  if (command.action == egomod::Command::Action::kRun) {
    return egomod::run_daemon(command.config, command.quiet);
  }
  std::fputs(command.text.c_str(), stdout);
  return command.exit_code;
}
