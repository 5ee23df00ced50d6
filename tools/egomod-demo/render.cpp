// SPDX-License-Identifier: Apache-2.0
#include "render.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

#include "kitti_writer.hpp"
#include "scenes.hpp"

namespace egomod::demo {
namespace {

namespace world = test_support;
using Clock = std::chrono::steady_clock;

std::map<std::string, std::function<world::Scene()>> scenes() {
  return {{"tour", world::demo_tour},
          {"static", world::static_room},
          {"following", world::following_robot},
          {"crossing", world::crossing_robot},
          {"resting", world::resting_rig_crossing_robot}};
}

// On a terminal one line that is redrawn, elsewhere a line every ten seconds.
class Progress {
 public:
  explicit Progress(int total) : total_(total), on_terminal_(isatty(STDERR_FILENO) != 0) {}

  void show(int done) {
    const auto now = Clock::now();
    const auto interval = on_terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(10);
    if (now - shown_ < interval && done != total_) return;
    shown_ = now;
    const double rate_hz =
        done / std::max(std::chrono::duration<double>(now - start_).count(), 1e-3);
    fmt::print(stderr, "{}rendered {} of {} pairs, {:.1f} a second, {:.0f} s left   {}",
               on_terminal_ ? "\r" : "", done, total_, rate_hz, (total_ - done) / rate_hz,
               on_terminal_ && done != total_ ? "" : "\n");
    std::fflush(stderr);
  }

 private:
  int total_;
  bool on_terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
};

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& [name, scene] : scenes()) names.push_back(name);
  return names;
}

void render(const RenderOptions& options) {
  const int pairs = std::max(1, static_cast<int>(std::lround(options.seconds * options.rate_hz)));
  Progress progress(pairs);
  const world::SyntheticWorld rendered(scenes().at(options.scene)(),
                                       world::kinect_pair(options.width_px),
                                       {.noise_sigma = options.noise_sigma});
  world::write_kitti_sequence(rendered, {.rate_hz = options.rate_hz, .pairs = pairs},
                              options.folder, [&](int done) { progress.show(done); });
}

}  // namespace egomod::demo
