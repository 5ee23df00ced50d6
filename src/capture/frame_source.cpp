// SPDX-License-Identifier: Apache-2.0
#include "egomod/capture/frame_source.hpp"

#include "capture/sim_source.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

constexpr const char* kAvailable = "this build has folder:DIR, log:FILE, lcm and sim[:WORLD]";

}  // namespace

std::unique_ptr<FrameSource> open_source(const std::string& spec, const CaptureConfig& config,
                                         const std::string& rig_file, const std::string& lcm_url,
                                         bool realtime) {
  const std::size_t colon = spec.find(':');
  const std::string kind = spec.substr(0, colon);
  const std::string argument = colon == std::string::npos ? "" : spec.substr(colon + 1);
  if (kind == "folder") return open_folder_source(argument, config, rig_file);
  if (kind == "log") return open_log_source(argument, config, rig_file);
  if (spec == "lcm") return open_lcm_source(lcm_url, config, rig_file);
  if (kind == "sim") {
    return open_sim_source({.program = find_simulator(),
                            .world = argument,
                            .rig_file = rig_file,
                            .lcm_url = lcm_url,
                            .realtime = realtime},
                           config);
  }
  throw SourceError("source '" + spec + "' is unknown or not built in; " + kAvailable);
}

}  // namespace egomod
