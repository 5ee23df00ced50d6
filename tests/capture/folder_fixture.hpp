// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "egomod/capture/frame_source.hpp"

namespace egomod {

// A folder of its own for each test, gone afterwards.
class TemporaryFolder : public ::testing::Test {
 protected:
  TemporaryFolder();
  ~TemporaryFolder() override;

  void write(const std::string& name, const std::string& text) const;
  // 8-bit grey.
  void write_png(const std::string& name, int width_px, int height_px,
                 const std::function<int(int u, int v)>& grey) const;
  void write_rgb_png(const std::string& name, int width_px, int height_px, int red, int green,
                     int blue) const;
  void write_png16(const std::string& name, int width_px, int height_px, int value) const;

  // KITTI odometry layout: image i is filled with 10 i on the left and 10 i + 5 on the right.
  void write_kitti(int images, double interval_s = 0.1) const;
  void write_times(const std::string& name, int count, double interval_s, double offset_s) const;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] std::string spec() const { return "folder:" + folder_.string(); }
  // The text of the SourceError that opening throws; empty if it does not.
  [[nodiscard]] std::string error_of_opening(const CaptureConfig& config = {},
                                             const std::string& rig_file = {}) const;

  std::filesystem::path folder_;

  static constexpr int kWidth_px = 40;
  static constexpr int kHeight_px = 30;
};

}  // namespace egomod
