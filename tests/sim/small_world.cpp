// SPDX-License-Identifier: Apache-2.0
#include "small_world.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "world_file.hpp"

namespace egomod::sim::test {
namespace {

constexpr const char* kHead = "duration_s = 1.0\nseed = 5\n";
constexpr const char* kCamera =
    "[camera]\nwidth_px = 160\nheight_px = 120\nbaseline_m = 0.2\nrate_hz = 30.0\n";
constexpr const char* kRoom = R"(
[shell]
kind = "room"
width_m = 2.4
length_m = 3.0
height_m = 1.5
rear_m = 0.3
[rig]
motion = { kind = "arc", position_m = [0.0, 0.0], speed_mps = 0.3, turn_degps = 10.0 }
[[object]]
kind = "pioneer"
motion = { kind = "line", position_m = [-0.8, 1.8], heading_deg = 90.0, speed_mps = 0.5 }
[[object]]
kind = "box"
size_m = [0.4, 0.5, 0.2]
motion = { kind = "spin", position_m = [0.6, 2.4], turn_degps = 60.0 }
[[furniture]]
position_m = [-0.9, 2.4]
size_m = [0.4, 0.8, 0.4]
)";
constexpr const char* kUnreal = R"(
focal_px = 140.0
[camera.left]
focal_px = 127.0
cx_px = 80.4
distortion = [-0.12, 0.02, 0.001, -0.0005, 0.0]
[camera.right]
focal_px = 128.0
cy_px = 58.8
distortion = [-0.11, 0.02, 0.0, 0.0008, 0.001]
yaw_deg = 0.6
roll_deg = -0.5
[calibration_error]
right_pitch_deg = 0.1
[realism]
exposure_s = 0.008
blur_samples = 2
readout_s = 0.02
readout_strips = 12
[timing]
jitter_s = 0.001
right_offset_s = 0.006
right_drift_ppm = 500.0
drop_probability = 0.1
late_probability = 0.2
late_s = 0.05
)";

}  // namespace

World world_of(const std::string& text) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("egomod_world_" + std::to_string(getpid()) + ".toml");
  std::ofstream(file) << text;
  struct Remove {
    const std::filesystem::path& file;
    ~Remove() { std::filesystem::remove(file); }
  } const remove{file};
  return read_world(file);
}

std::string small_room() { return std::string(kHead) + kCamera + kRoom; }

std::string unreal_room() { return std::string(kHead) + kCamera + kUnreal + kRoom; }

}  // namespace egomod::sim::test
