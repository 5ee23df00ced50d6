// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/version.hpp"

#include "service_manager.hpp"

namespace egomod {

std::string version_text() {
  std::string text = "egomodd " EGOMOD_VERSION "\n";
  text += "sources: folder, log, lcm, sim\n";
  text += std::string("systemd: ") + (has_service_manager_support() ? "yes" : "no") + "\n";
  return text;
}

}  // namespace egomod
