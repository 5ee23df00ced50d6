// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace egomod {

// The source `sim`: a world that egomod-sim renders, a process of its own.
struct SimSettings {
  std::filesystem::path program{};  // egomod-sim
  std::string world{};              // name or path; empty: the default one
  std::string rig_file{};           // empty: the world's calibration
  std::string lcm_url{};            // where a driven rig listens; empty: as the daemon's own
  bool realtime = false;            // by the wall clock, instead of in lockstep
  std::chrono::milliseconds patience{60000};  // with a simulator that says nothing
};

// Throws SourceError, with what the simulator said if it could not begin.
[[nodiscard]] std::unique_ptr<FrameSource> open_sim_source(const SimSettings& settings,
                                                           const CaptureConfig& config);

// egomod-sim beside this program, in ../libexec/egomod or in $PATH. Throws SourceError that names
// the package when it is nowhere.
[[nodiscard]] std::filesystem::path find_simulator();

}  // namespace egomod
