// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace lcm {
class LCM;
}

namespace egomod {

// The source `lcm` on a bus that the caller made, such as memq://. It must outlive the source, and
// nobody else may handle its messages.
[[nodiscard]] std::unique_ptr<FrameSource> open_lcm_source(lcm::LCM& bus,
                                                           const CaptureConfig& config,
                                                           const std::string& rig_file);

}  // namespace egomod
