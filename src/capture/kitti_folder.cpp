// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <set>
#include <string>

#include "capture/calibration_file.hpp"
#include "capture/folder_contents.hpp"
#include "capture/text_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kIndexDigits = 6;
constexpr double kMaxTime_s = 9e9;  // microseconds of it still fit an int64 after * 1000

std::string file_name(std::size_t index) {
  std::string digits = std::to_string(index);
  if (digits.size() < kIndexDigits) digits.insert(0, kIndexDigits - digits.size(), '0');
  return digits + ".png";
}

// Exactly round(1e6 t) microseconds.
Nanoseconds read_time(const std::string& text, const std::string& where) {
  const std::vector<double> numbers = parse_numbers(text, where);
  if (numbers.size() != 1) throw SourceError(where + ": expected one time in seconds a line");
  if (std::abs(numbers[0]) > kMaxTime_s) throw SourceError(where + ": the time is out of range");
  return std::chrono::microseconds(std::llround(1e6 * numbers[0]));
}

std::vector<Nanoseconds> read_times(const fs::path& file) {
  if (!fs::exists(file)) {
    throw SourceError(file.string() + " is missing: it gives the time of each image in seconds, " +
                      "one a line");
  }
  std::vector<Nanoseconds> times;
  for (const auto& [number, text] : read_lines(file)) {
    const Nanoseconds time = read_time(text, at(file, number));
    if (!times.empty() && time <= times.back()) {
      throw SourceError(at(file, number) + ": the time " +
                        (time == times.back() ? "repeats" : "runs backwards") +
                        "; times must ascend by at least a microsecond");
    }
    times.push_back(time);
  }
  return times;
}

// Indices of the files named %06d.png.
std::set<std::size_t> image_indices(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw SourceError(folder.string() + ": the folder is missing");
  std::set<std::size_t> indices;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const std::size_t digits = name.find_first_not_of("0123456789");
    if (digits < kIndexDigits || digits > 9 || name.substr(digits) != ".png") continue;
    const auto index = static_cast<std::size_t>(std::stoul(name.substr(0, digits)));
    if (file_name(index) == name) indices.insert(index);
  }
  return indices;
}

FolderContents::Camera list_camera(const fs::path& folder, const fs::path& times_file) {
  FolderContents::Camera camera;
  camera.exposures = read_times(times_file);
  const std::set<std::size_t> indices = image_indices(folder);
  if (indices.empty())
    throw SourceError(folder.string() + ": holds no images named 000000.png, ...");
  for (std::size_t i = 0; i < camera.exposures.size() || i <= *indices.rbegin(); ++i) {
    const fs::path file = folder / file_name(i);
    if (!indices.contains(i)) {
      throw SourceError(file.string() + " is missing: " + times_file.filename().string() + " has " +
                        std::to_string(camera.exposures.size()) + " times, the folder " +
                        std::to_string(indices.size()) + " images");
    }
    camera.files.push_back(file);
  }
  if (camera.files.size() != camera.exposures.size()) {
    throw SourceError(folder.string() + ": " + std::to_string(camera.files.size()) +
                      " images, but " + times_file.string() + " has " +
                      std::to_string(camera.exposures.size()) + " times; each image needs one");
  }
  return camera;
}

void require_equal_counts(const fs::path& folder, std::size_t left) {
  const std::set<std::size_t> right = image_indices(folder / "image_1");
  if (left == right.size()) return;
  std::size_t missing = 0;
  while (right.contains(missing)) ++missing;
  const std::string first =
      missing < left ? ", first missing " + (folder / "image_1" / file_name(missing)).string() : "";
  throw SourceError(folder.string() + ": image_0 has " + std::to_string(left) +
                    " images and image_1 " + std::to_string(right.size()) + first +
                    "; restore what is missing, or give the right camera's own times in " +
                    "times_right.txt");
}

void read_calibration(const fs::path& folder, FolderContents& contents) {
  contents.calibration_file = (folder / "calib_full.txt").string();
  if (fs::exists(contents.calibration_file)) {
    contents.calibration = read_kitti_raw_calibration(contents.calibration_file);
    return;
  }
  if (!fs::exists(folder / "calib.txt")) {
    throw SourceError((folder / "calib.txt").string() +
                      " is missing: add it (P0: and P1: of the rectified cameras), or name a rig " +
                      "file with --rig");
  }
  contents.calibration_file = (folder / "calib.txt").string();
  contents.calibration = read_kitti_calibration(contents.calibration_file);
}

}  // namespace

FolderContents read_kitti_folder(const fs::path& folder, bool rig_file_given) {
  FolderContents contents;
  const fs::path right_times = folder / "times_right.txt";
  contents.is_paired_by_index = !fs::exists(right_times);
  if (!rig_file_given) read_calibration(folder, contents);
  contents.left = list_camera(folder / "image_0", folder / "times.txt");
  if (contents.is_paired_by_index) require_equal_counts(folder, contents.left.files.size());
  contents.right = list_camera(folder / "image_1",
                               contents.is_paired_by_index ? folder / "times.txt" : right_times);
  return contents;
}

}  // namespace egomod
