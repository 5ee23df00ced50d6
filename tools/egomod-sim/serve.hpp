// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "simulator.hpp"

namespace egomod::sim {

struct ServeOptions {
  int socket = -1;
  bool realtime = false;  // by the wall clock: pairs that there is no time for are left out
  std::string lcm_url;    // where a driven rig listens; empty: LCM_DEFAULT_URL, else LCM's default
};

// Hands the daemon at the other end of the socket one pair after the other, until the world or the
// daemon ends. Throws ServeError.
void serve(Simulator& simulator, const ServeOptions& options);

}  // namespace egomod::sim
