// SPDX-License-Identifier: Apache-2.0
#include "folder_writer.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "calibration_writer.hpp"
#include "kitti_writer.hpp"

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;

std::ofstream opened(const fs::path& file) {
  std::ofstream out(file);
  if (!out) throw std::runtime_error("cannot write " + file.string());
  out.exceptions(std::ios::badbit | std::ios::failbit);
  return out;
}

std::vector<std::uint16_t> millimetres(const std::vector<float>& depth_m) {
  std::vector<std::uint16_t> out;
  out.reserve(depth_m.size());
  for (const float z : depth_m) {
    out.push_back(z < 65.535F ? static_cast<std::uint16_t>(std::lround(1000.0F * z)) : 0U);
  }
  return out;
}

// Pairs of an earlier, longer run would stay behind the last one and be read as part of this.
fs::path emptied(const fs::path& folder) {
  fs::create_directories(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") fs::remove(entry.path());
  }
  return folder;
}

}  // namespace

FolderWriter::FolderWriter(const fs::path& folder, const World& world, FolderOptions options)
    : folder_(folder), camera_(world.camera), options_(options) {
  for (const char* name : {"image_0", "image_1"}) emptied(folder / name);
  if (options.depth) emptied(folder / "depth_0");
  if (options.masks) emptied(folder / "mask_0");
  // Of an earlier run: they would change what the images are taken for.
  for (const char* name : {"calib_full.txt", "times_right.txt"}) fs::remove(folder / name);
  test_support::write_calibration(camera_, folder / "calib.txt");
  if (world.optics.images_are_raw) {
    write_raw_calibration(written_calibration(camera_, world.optics), folder / "calib_full.txt");
  }
  times_ = opened(folder / "times.txt");
  if (!world.timing.is_paired()) right_times_ = opened(folder / "times_right.txt");
  poses_ = opened(folder / "poses.txt");
  objects_ = opened(folder / "objects.csv");
  objects_ << test_support::kObjectsHeader;
}

void FolderWriter::write_left(double t_s, Image& image, Truth& truth) {
  write_truth(t_s, truth);
  write_image("image_0", left_count_, image);
  const std::string name = fmt::format("{:06d}.png", left_count_);
  const auto [width, height] = std::pair{camera_.width_px, camera_.height_px};
  if (options_.masks) {
    queue_.push([file = folder_ / "mask_0" / name, width = width, height = height,
                 ids = truth.buffers.ids] {
      test_support::write_png(file, {ids.data(), width, height, width});
    });
  }
  if (options_.depth) {
    queue_.push([file = folder_ / "depth_0" / name, width = width, height = height,
                 depth_m = truth.buffers.depth_m] {
      test_support::write_png16(file, millimetres(depth_m), width, height);
    });
  }
  ++left_count_;
}

void FolderWriter::write_right(double t_s, Image& image) {
  if (right_times_.is_open()) fmt::print(right_times_, "{:.6f}\n", t_s);
  write_image("image_1", right_count_++, image);
}

void FolderWriter::write_image(const char* subfolder, int index, Image& image) {
  // A job must be copyable, an image is not.
  const auto taken = std::make_shared<const Image>(std::exchange(image, Image()));
  queue_.push([taken, file = folder_ / subfolder / fmt::format("{:06d}.png", index)] {
    test_support::write_png(file, taken->view());
  });
}

void FolderWriter::finish() {
  queue_.finish();
  for (std::ofstream* file : {&times_, &right_times_, &poses_, &objects_}) {
    if (file->is_open()) file->close();
  }
}

void FolderWriter::write_truth(double t_s, const Truth& truth) {
  fmt::print(times_, "{:.6f}\n", t_s);
  test_support::write_pose(truth.T_first_current, poses_);
  for (const ObjectState& object : truth.objects) {
    test_support::write_object(left_count_, t_s, object.kind, object.truth, objects_);
  }
}

}  // namespace egomod::sim
