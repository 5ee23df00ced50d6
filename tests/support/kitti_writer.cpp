// SPDX-License-Identifier: Apache-2.0
#include "kitti_writer.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <exception>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace egomod::test_support {
namespace {

namespace fs = std::filesystem;

std::ofstream opened(const fs::path& file) {
  std::ofstream out(file);
  out.exceptions(std::ios::badbit | std::ios::failbit);
  return out;
}

}  // namespace

void write_calibration(const StereoCamera& c, const fs::path& file) {
  auto out = opened(file);
  fmt::print(out, "P0: {0} 0 {2} 0 0 {1} {3} 0 0 0 1 0\n", c.fx_px, c.fy_px, c.cx_px, c.cy_px);
  fmt::print(out, "P1: {0} 0 {2} {4} 0 {1} {3} 0 0 0 1 0\n", c.fx_px, c.fy_px, c.cx_px, c.cy_px,
             -c.fx_px * c.baseline_m);
}

void write_pose(const Eigen::Isometry3d& T, std::ostream& out) {
  for (int i = 0; i < 12; ++i) {
    fmt::print(out, "{:.9g}{}", T.matrix()(i / 4, i % 4), i == 11 ? '\n' : ' ');
  }
}

namespace {

void write_vector(const Eigen::Vector3d& v, std::ostream& out) {
  fmt::print(out, ",{:.5f},{:.5f},{:.5f}", v.x(), v.y(), v.z());
}

}  // namespace

void write_object(int frame, double t_s, std::string_view kind, const ObjectTruth& o,
                  std::ostream& out) {
  if (o.visible_px == 0) return;
  fmt::print(out, "{},{:.6f},{},{}", frame, t_s, o.id, kind);
  write_vector(o.surface_centroid_m, out);
  write_vector(o.box_centre_m, out);
  // Readers carry it from the centre to where they need it, by the angular velocity.
  const Eigen::Vector3d lever_m = o.box_centre_m - o.surface_centroid_m;
  write_vector(o.velocity_mps + o.angular_velocity_radps.cross(lever_m), out);
  write_vector(o.angular_velocity_radps, out);
  fmt::print(out, ",{},{},{},{},{},{:.4f},{}\n", o.u_min_px, o.v_min_px, o.u_max_px, o.v_max_px,
             o.visible_px, o.occluded_fraction, o.moving ? 1 : 0);
}

namespace {

void write_pair(const SyntheticWorld& world, double t_s, int index, const fs::path& folder,
                Image& left, Image& right) {
  world.render(t_s, left, right);
  const std::string name = fmt::format("{:06d}.png", index);
  write_png(folder / "image_0" / name, left.view());
  write_png(folder / "image_1" / name, right.view());
}

// On every core; the first error ends all of them.
void write_images(const SyntheticWorld& world, const Recording& recording, const fs::path& folder) {
  std::atomic<int> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    Image left;
    Image right;
    for (int i = next++; i < recording.pairs; i = next++) {
      try {
        write_pair(world, i / recording.rate_hz, i, folder, left, right);
      } catch (...) {
        const std::lock_guard lock(mutex);
        error = std::current_exception();
        next = recording.pairs;
      }
    }
  };
  {
    std::vector<std::jthread> workers(std::max(1U, std::thread::hardware_concurrency()));
    for (std::jthread& worker : workers) worker = std::jthread(work);
  }
  if (error) std::rethrow_exception(error);
}

void write_truth(const SyntheticWorld& world, const Recording& recording, const fs::path& folder) {
  auto times = opened(folder / "times.txt");
  auto poses = opened(folder / "poses.txt");
  auto objects = opened(folder / "objects.csv");
  objects << kObjectsHeader;
  for (int i = 0; i < recording.pairs; ++i) {
    const double t_s = i / recording.rate_hz;
    fmt::print(times, "{:.6f}\n", t_s);
    write_pose(world.T_first_current(t_s), poses);
    for (const ObjectTruth& object : world.objects(t_s)) {
      write_object(i, t_s, "robot", object, objects);
    }
  }
}

void write_png_as(png_uint_32 format, const fs::path& file, int width_px, int height_px,
                  const void* pixels, png_int_32 row_stride) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(width_px);
  png.height = static_cast<png_uint_32>(height_px);
  png.format = format;
  png.flags = PNG_IMAGE_FLAG_FAST;
  if (png_image_write_to_file(&png, file.c_str(), 0, pixels, row_stride, nullptr) == 0) {
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), png.message));
  }
}

}  // namespace

void write_png(const fs::path& file, const ImageView& image) {
  write_png_as(PNG_FORMAT_GRAY, file, image.width_px, image.height_px, image.data,
               static_cast<png_int_32>(image.stride_bytes));
}

void write_png16(const fs::path& file, std::span<const std::uint16_t> pixels, int width_px,
                 int height_px) {
  write_png_as(PNG_FORMAT_LINEAR_Y, file, width_px, height_px, pixels.data(), width_px);
}

void write_kitti_sequence(const SyntheticWorld& world, const Recording& recording,
                          const fs::path& folder) {
  fs::create_directories(folder / "image_0");
  fs::create_directories(folder / "image_1");
  write_calibration(world.camera(), folder / "calib.txt");
  write_images(world, recording, folder);
  write_truth(world, recording, folder);
}

}  // namespace egomod::test_support
