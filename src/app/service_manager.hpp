// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod {

// sd_notify(3): "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1". Nothing outside systemd, and
// nothing where the program was built without libsystemd.
void notify_service_manager(const std::string& state);
[[nodiscard]] bool has_service_manager_support();

}  // namespace egomod
