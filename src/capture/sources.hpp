// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace egomod {

// One file a source. All throw SourceError.
[[nodiscard]] std::unique_ptr<FrameSource> open_folder_source(const std::string& folder,
                                                              const CaptureConfig& config,
                                                              const std::string& rig_file);
[[nodiscard]] std::unique_ptr<FrameSource> open_log_source(const std::string& file,
                                                           const CaptureConfig& config,
                                                           const std::string& rig_file);
[[nodiscard]] std::unique_ptr<FrameSource> open_lcm_source(const BusAddress& address,
                                                           const CaptureConfig& config,
                                                           const std::string& rig_file);

}  // namespace egomod
