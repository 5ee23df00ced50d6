// SPDX-License-Identifier: Apache-2.0
#include "bench_pairs.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>

#include "scenes.hpp"
#include "synthetic_world.hpp"

namespace egomod::bench {
namespace {

constexpr int kMaxPairs = 90;
constexpr int kRenderedPairs = 30;
constexpr double kRenderedRate_hz = 30.0;

std::filesystem::path sequence_folder() {
  const char* const data = std::getenv("EGOMOD_DATA_DIR");
  if (data == nullptr) return {};
  const char* const sequence = std::getenv("EGOMOD_BENCH_SEQUENCE");
  return std::filesystem::path(data) / (sequence ? sequence : "rendered_crossing_turn_640");
}

std::filesystem::path image_file(const std::filesystem::path& folder, int camera, int index) {
  char name[32];
  std::snprintf(name, sizeof(name), "image_%d/%06d.png", camera, index);
  return folder / name;
}

void read_image(const std::filesystem::path& file, Image& image) {
  const cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (grey.empty()) throw std::runtime_error("cannot read " + file.string());
  copy_image({grey.data, grey.cols, grey.rows, static_cast<std::ptrdiff_t>(grey.step)}, image);
}

std::array<double, 12> read_projection(std::istream& calibration, const std::string& key) {
  std::string line, name;
  while (std::getline(calibration, line)) {
    std::istringstream words(line);
    std::array<double, 12> P{};
    if (!(words >> name) || name != key) continue;
    for (double& x : P) words >> x;
    if (words) return P;
  }
  throw std::runtime_error("calib.txt has no row " + key);
}

StereoCamera read_camera(const std::filesystem::path& folder) {
  std::ifstream calibration(folder / "calib.txt");
  const auto P0 = read_projection(calibration, "P0:");
  const auto P1 = read_projection(calibration, "P1:");
  return {
      .fx_px = P0[0], .fy_px = P0[5], .cx_px = P0[2], .cy_px = P0[6], .baseline_m = -P1[3] / P1[0]};
}

Nanoseconds from_seconds(double t_s) {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(t_s));
}

std::vector<StereoPair> read_sequence(const std::filesystem::path& folder) {
  std::ifstream times(folder / "times.txt");
  if (!times) throw std::runtime_error("cannot read " + (folder / "times.txt").string());
  const StereoCamera camera = read_camera(folder);
  std::vector<StereoPair> pairs;
  for (double t_s; static_cast<int>(pairs.size()) < kMaxPairs && times >> t_s;) {
    const int index = static_cast<int>(pairs.size());
    StereoPair& pair = pairs.emplace_back();
    pair.sequence = static_cast<std::uint64_t>(index);
    pair.exposure = pair.right_exposure = from_seconds(t_s);
    read_image(image_file(folder, 0, index), pair.left);
    read_image(image_file(folder, 1, index), pair.right);
    pair.calibration.camera = camera;
    pair.calibration.camera.width_px = pair.left.width_px();
    pair.calibration.camera.height_px = pair.left.height_px();
  }
  return pairs;
}

}  // namespace

std::vector<StereoPair> rendered_pairs(int width_px) {
  const test_support::SyntheticWorld world(
      test_support::crossing_robot(), test_support::kinect_pair(width_px), {.noise_sigma = 2.0});
  std::vector<StereoPair> pairs(kRenderedPairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double t_s = static_cast<double>(i) / kRenderedRate_hz;
    pairs[i].sequence = i;
    pairs[i].exposure = pairs[i].right_exposure = from_seconds(t_s);
    pairs[i].calibration.camera = world.camera();
    world.render(t_s, pairs[i].left, pairs[i].right);
  }
  return pairs;
}

std::vector<StereoPair> load_pairs() {
  const auto folder = sequence_folder();
  auto pairs = folder.empty() ? rendered_pairs() : read_sequence(folder);
  if (pairs.size() < 2) throw std::runtime_error(folder.string() + ": fewer than two pairs");
  return pairs;
}

std::string pairs_name() {
  const auto folder = sequence_folder();
  return folder.empty() ? "rendered crossing robot" : folder.filename().string();
}

}  // namespace egomod::bench
