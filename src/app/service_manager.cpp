// SPDX-License-Identifier: Apache-2.0
#include "service_manager.hpp"

#ifdef EGOMOD_HAVE_SYSTEMD
#include <systemd/sd-daemon.h>
#endif

namespace egomod {

#ifdef EGOMOD_HAVE_SYSTEMD
void notify_service_manager(const std::string& state) { sd_notify(0, state.c_str()); }
bool has_service_manager_support() { return true; }
#else
void notify_service_manager(const std::string&) {}
bool has_service_manager_support() { return false; }
#endif

}  // namespace egomod
