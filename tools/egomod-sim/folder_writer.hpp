// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>

#include "egomod/core/image.hpp"
#include "simulator.hpp"

namespace egomod::sim {

struct FolderOptions {
  bool depth = false;  // depth_0/%06d.png: 16 bits, millimetres, 0: none or beyond 65.535 m
  bool masks = false;  // mask_0/%06d.png: object ids
};

// A folder of the KITTI odometry layout with truth: image_0, image_1, calib.txt, times.txt,
// poses.txt, objects.csv. Images are compressed in another thread while the next pair is rendered.
// Throws std::runtime_error or std::ios::failure. Threads: one caller.
class FolderWriter {
 public:
  FolderWriter(const std::filesystem::path& folder, const StereoCamera& camera,
               FolderOptions options);
  // Takes the images and the truth over by swapping; what comes back is old and may be overwritten.
  void write(std::uint64_t pair, double t_s, Image& left, Image& right, Truth& truth);
  void finish();

 private:
  struct Job {
    std::string name;
    Image left;
    Image right;
    Buffers buffers;
  };
  void write_truth(std::uint64_t pair, double t_s, const Truth& truth);
  void write_images(const Job& job) const;

  std::filesystem::path folder_;
  StereoCamera camera_;
  FolderOptions options_;
  std::ofstream times_;
  std::ofstream poses_;
  std::ofstream objects_;
  Job job_;
  std::future<void> writing_;  // last: its thread reads the rest
};

}  // namespace egomod::sim
