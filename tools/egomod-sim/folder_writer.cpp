// SPDX-License-Identifier: Apache-2.0
#include "folder_writer.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cmath>
#include <stdexcept>
#include <vector>

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

FolderWriter::FolderWriter(const fs::path& folder, const StereoCamera& camera,
                           FolderOptions options)
    : folder_(folder), camera_(camera), options_(options) {
  for (const char* name : {"image_0", "image_1"}) emptied(folder / name);
  if (options.depth) emptied(folder / "depth_0");
  if (options.masks) emptied(folder / "mask_0");
  test_support::write_calibration(camera, folder / "calib.txt");
  times_ = opened(folder / "times.txt");
  poses_ = opened(folder / "poses.txt");
  objects_ = opened(folder / "objects.csv");
  objects_ << test_support::kObjectsHeader;
}

void FolderWriter::write(std::uint64_t pair, double t_s, Image& left, Image& right, Truth& truth) {
  write_truth(pair, t_s, truth);
  if (writing_.valid()) writing_.get();
  job_.name = fmt::format("{:06d}.png", pair);
  std::swap(job_.left, left);
  std::swap(job_.right, right);
  std::swap(job_.buffers, truth.buffers);
  writing_ = std::async(std::launch::async, [this] { write_images(job_); });
}

void FolderWriter::finish() {
  if (writing_.valid()) writing_.get();
  for (std::ofstream* file : {&times_, &poses_, &objects_}) file->close();
}

void FolderWriter::write_truth(std::uint64_t pair, double t_s, const Truth& truth) {
  fmt::print(times_, "{:.6f}\n", t_s);
  test_support::write_pose(truth.T_first_current, poses_);
  for (const ObjectState& object : truth.objects) {
    test_support::write_object(static_cast<int>(pair), t_s, object.kind, object.truth, objects_);
  }
}

void FolderWriter::write_images(const Job& job) const {
  const auto [width, height] = std::pair{camera_.width_px, camera_.height_px};
  test_support::write_png(folder_ / "image_0" / job.name, job.left.view());
  test_support::write_png(folder_ / "image_1" / job.name, job.right.view());
  if (options_.masks) {
    test_support::write_png(folder_ / "mask_0" / job.name,
                            {job.buffers.ids.data(), width, height, width});
  }
  if (options_.depth) {
    test_support::write_png16(folder_ / "depth_0" / job.name, millimetres(job.buffers.depth_m),
                              width, height);
  }
}

}  // namespace egomod::sim
