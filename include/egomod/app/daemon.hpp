// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/app/config.hpp"

namespace egomod {

// Takes SIGINT and SIGTERM from this thread and all that it starts: they are waited for in one
// place. Call first.
void block_signals();

// Builds source, stages and publisher, runs them to the end of the source or a signal, and says how
// it went. Returns an ExitCode.
[[nodiscard]] int run_daemon(const Config& config, bool quiet);

}  // namespace egomod
