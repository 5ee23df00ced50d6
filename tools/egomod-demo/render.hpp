// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace egomod::demo {

struct RenderOptions {
  std::string scene = "tour";
  std::string folder;
  double seconds = 8.0;
  double rate_hz = 30.0;
  double noise_sigma = 2.0;  // grey levels
  int width_px = 640;
};

[[nodiscard]] std::vector<std::string> scene_names();
// Writes a rendered sequence with its truth, KITTI odometry layout; shows progress on stderr.
void render(const RenderOptions& options);

}  // namespace egomod::demo
