// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "egomod/app/config.hpp"

namespace egomod {

// Exit codes of every program.
enum ExitCode : int {
  kExitSuccess = 0,  // the end of a replay, or asked to stop
  kExitFailure = 1,  // something failed while running
  kExitUsage = 2,    // the command line is refused; nothing was started
  kExitConfig = 78,  // the configuration is (sysexits.h: EX_CONFIG)
};

struct Command {
  enum class Action {
    kRun,
    kPrint,   // print `text`, exit with `exit_code`
    kRefuse,  // the same on stderr
  };
  Action action = Action::kRun;
  std::string text{};
  int exit_code = kExitSuccess;
  Config config{};
  bool quiet = false;  // neither progress nor summary
};

// Defaults < --preset < --config < --set and the named options.
[[nodiscard]] Command parse_command_line(int argc, const char* const* argv);

}  // namespace egomod
