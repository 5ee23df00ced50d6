// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>

#include "egomod/core/image.hpp"
#include "simulator.hpp"
#include "write_queue.hpp"

namespace egomod::sim {

struct FolderOptions {
  bool depth = false;  // depth_0/%06d.png: 16 bits, millimetres, 0: none or beyond 65.535 m
  bool masks = false;  // mask_0/%06d.png: object ids
};

// A folder of the KITTI odometry layout with truth: image_0, image_1, calib.txt, times.txt,
// poses.txt, objects.csv; calib_full.txt where images are raw, times_right.txt where the cameras
// do not deliver pairs. Images are numbered as they come, without a gap. Throws std::runtime_error
// or std::ios::failure. Threads: one caller.
class FolderWriter {
 public:
  FolderWriter(const std::filesystem::path& folder, const World& world, FolderOptions options);
  // Images and buffers are taken over; what comes back is empty. `t_s` ascends.
  void write_left(double t_s, Image& image, Truth& truth);
  void write_right(double t_s, Image& image);
  void finish();

 private:
  void write_truth(double t_s, const Truth& truth);
  void write_image(const char* subfolder, int index, Image& image);

  std::filesystem::path folder_;
  StereoCamera camera_;
  FolderOptions options_;
  int left_count_ = 0;
  int right_count_ = 0;
  std::ofstream times_;
  std::ofstream right_times_;  // not open where images come as pairs
  std::ofstream poses_;
  std::ofstream objects_;
  WriteQueue queue_;
};

}  // namespace egomod::sim
