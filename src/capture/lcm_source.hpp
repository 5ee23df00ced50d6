// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace lcm {
class LCM;
}

namespace egomod {

// The URL with a receive buffer that holds whole images, if it names none; empty stands for
// $LCM_DEFAULT_URL, or LCM's default group.
[[nodiscard]] std::string with_receive_buffer(const std::string& url);

// The source `lcm` on a bus that the caller made, such as memq://. It must outlive the source, and
// nobody else may handle its messages.
[[nodiscard]] std::unique_ptr<FrameSource> open_lcm_source(lcm::LCM& bus,
                                                           const CaptureConfig& config,
                                                           const std::string& rig_file);

}  // namespace egomod
