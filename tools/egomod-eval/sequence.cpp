// SPDX-License-Identifier: Apache-2.0
#include "sequence.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "tables.hpp"

namespace egomod::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxFrame = 1e9;
// A quaternion whose length is further from one is something else.
constexpr double kUnitTolerance = 0.01;

std::vector<double> read_times(const fs::path& file) {
  std::vector<double> times_s;
  for (const NumberRow& row : read_numbers(file)) {
    const double time_s = row.numbers.front();
    if (!std::isfinite(time_s) || (!times_s.empty() && time_s <= times_s.back())) {
      fail_at(file, row.line, "times must be finite and ascend");
    }
    times_s.push_back(time_s);
  }
  if (times_s.size() < 2) throw InputError(file.string() + ": holds fewer than two times");
  return times_s;
}

Eigen::Isometry3d pose_of(const double* numbers) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = numbers[i];
  return T;
}

Poses read_kitti(const fs::path& file) {
  Poses poses;
  for (const NumberRow& row : read_numbers(file)) {
    const std::size_t count = row.numbers.size();
    if (count != 12 && count != 13) {
      fail_at(file, row.line,
              std::to_string(count) + " numbers; a pose has 12, or 13 with the " + "frame first");
    }
    const bool numbered = count == 13;
    const double frame = numbered ? row.numbers[0] : static_cast<double>(poses.size());
    if (!(std::abs(frame) < kMaxFrame) || frame != std::floor(frame)) {
      fail_at(file, row.line, "the frame is not a whole number");
    }
    const int last = poses.empty() ? -1 : poses.back().frame;
    if (frame <= last) fail_at(file, row.line, "frames must ascend from 0");
    poses.push_back({static_cast<int>(frame), pose_of(row.numbers.data() + (numbered ? 1 : 0))});
  }
  return poses;
}

// The frame whose time is nearest, if it is within half the usual interval.
std::optional<int> frame_at(double time_s, const std::vector<double>& times_s) {
  const auto after = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  auto nearest = after == times_s.end() ? std::prev(after) : after;
  if (after != times_s.begin() &&
      std::abs(*std::prev(after) - time_s) < std::abs(*nearest - time_s))
    nearest = std::prev(after);
  const double interval_s =
      (times_s.back() - times_s.front()) / static_cast<double>(times_s.size() - 1);
  if (std::abs(*nearest - time_s) > 0.5 * interval_s) return std::nullopt;
  return static_cast<int>(nearest - times_s.begin());
}

Eigen::Isometry3d tum_pose(const fs::path& file, const NumberRow& row) {
  const auto& n = row.numbers;
  if (n.size() != 8) {
    fail_at(file, row.line,
            std::to_string(n.size()) + " numbers; a TUM pose has 8: time tx ty tz qx qy qz qw");
  }
  const Eigen::Quaterniond q(n[7], n[4], n[5], n[6]);
  if (std::abs(q.norm() - 1.0) > kUnitTolerance) {
    fail_at(file, row.line, "the quaternion is not of unit length");
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(n[1], n[2], n[3]);
  return T;
}

Poses read_tum(const fs::path& file, const std::vector<double>& times_s) {
  Poses poses;
  std::size_t strangers = 0;
  for (const NumberRow& row : read_numbers(file)) {
    const Eigen::Isometry3d T = tum_pose(file, row);
    const auto frame = frame_at(row.numbers[0], times_s);
    if (!frame) {
      ++strangers;
      continue;
    }
    if (!poses.empty() && *frame <= poses.back().frame) {
      fail_at(file, row.line, "timestamps must ascend, with at most one pose for each frame");
    }
    poses.push_back({*frame, T});
  }
  if (poses.empty() && strangers > 0) {
    throw InputError(file.string() + ": none of its timestamps is one of times.txt's (" +
                     std::to_string(times_s.front()) + " to " + std::to_string(times_s.back()) +
                     " s)");
  }
  return poses;
}

TruthObject truth_object(const Csv& csv, std::size_t row) {
  const auto n = [&](const char* column) { return csv.number(row, column); };
  TruthObject object;
  object.id = csv.text(row, "object_id");
  object.type = csv.text(row, "class");
  object.time_s = n("time");
  object.surface_m = {n("cx"), n("cy"), n("cz")};
  object.centre_m = {n("bx"), n("by"), n("bz")};
  object.velocity_mps = {n("VX"), n("VY"), n("VZ")};
  object.rectangle = {n("u_min"), n("v_min"), n("u_max"), n("v_max")};
  object.visible_px = static_cast<int>(n("visible_px"));
  const std::string& moving = csv.text(row, "moving");
  object.moving = moving == "1" || moving == "True" || moving == "true";
  if (!object.moving && moving != "0" && moving != "False" && moving != "false") {
    csv.fail(row, "column 'moving': '" + moving + "' is neither 0 nor 1");
  }
  // The truth's velocity is the box centre's; an estimate is that of the visible surface.
  const Eigen::Vector3d rotation_rate_radps(n("wx"), n("wy"), n("wz"));
  if (object.visible_px > 0)
    object.velocity_mps += rotation_rate_radps.cross(object.surface_m - object.centre_m);
  return object;
}

ByFrame<TruthObject> read_truth_objects(const fs::path& file) {
  const Csv csv(file, {"frame", "time",  "object_id", "class", "cx",         "cy",    "cz", "bx",
                       "by",    "bz",    "VX",        "VY",    "VZ",         "wx",    "wy", "wz",
                       "u_min", "v_min", "u_max",     "v_max", "visible_px", "moving"});
  ByFrame<TruthObject> objects;
  for (std::size_t row = 0; row < csv.rows(); ++row)
    objects[csv.index(row, "frame")].push_back(truth_object(csv, row));
  return objects;
}

ByFrame<Detection> read_detections(const fs::path& file) {
  const Csv csv(file, {"frame", "track_id", "u_min", "v_min", "u_max", "v_max", "X", "Y", "Z", "VX",
                       "VY", "VZ"});
  ByFrame<Detection> detections;
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    const auto n = [&](const char* column) { return csv.number(row, column); };
    const auto open = [&](const char* column) { return csv.number_or_nan(row, column); };
    Detection detection;
    detection.track = csv.text(row, "track_id");
    detection.time_s = open("time");
    detection.position_m = {open("X"), open("Y"), open("Z")};
    detection.velocity_mps = {open("VX"), open("VY"), open("VZ")};
    detection.rectangle = {n("u_min"), n("v_min"), n("u_max"), n("v_max")};
    detections[csv.index(row, "frame")].push_back(std::move(detection));
  }
  return detections;
}

void read_calibration(const fs::path& file, Truth& truth) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file.string() + ": cannot be read; scoring objects needs P1");
  std::size_t line_number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++line_number;
    if (line.rfind("P1:", 0) != 0) continue;
    std::istringstream numbers(line.substr(3));
    std::vector<double> P;
    for (double value = 0.0; numbers >> value;) P.push_back(value);
    if (P.size() != 12 || !(P[0] > 0.0) || !(P[3] < 0.0)) {
      fail_at(file, line_number, "P1 must be 12 numbers of a camera right of the left one");
    }
    truth.focal_px = P[0];
    truth.cx_px = P[2];
    truth.cy_px = P[6];
    truth.baseline_m = -P[3] / P[0];
    return;
  }
  throw InputError(file.string() + ": has no line 'P1:'");
}

void require_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder.string() + ": is no folder");
}

std::map<std::string, std::vector<double>> read_timing(const fs::path& file) {
  const Csv csv(file, {"frame", "stage", "ms"});
  std::map<std::string, std::vector<double>> stage_ms;
  for (std::size_t row = 0; row < csv.rows(); ++row)
    stage_ms[csv.text(row, "stage")].push_back(csv.number(row, "ms"));
  return stage_ms;
}

}  // namespace

double Truth::rate_hz() const {
  return static_cast<double>(times_s.size() - 1) / (times_s.back() - times_s.front());
}

Truth read_truth(const fs::path& folder) {
  require_folder(folder);
  Truth truth;
  truth.name = fs::absolute(folder / "x").lexically_normal().parent_path().filename().string();
  truth.folder = folder;
  truth.times_s = read_times(folder / "times.txt");
  if (fs::exists(folder / "poses.txt")) truth.poses = read_kitti(folder / "poses.txt");
  if (fs::exists(folder / "objects.csv")) {
    truth.objects = read_truth_objects(folder / "objects.csv");
    read_calibration(folder / "calib.txt", truth);
  }
  if (truth.poses.empty() && !truth.objects) {
    throw InputError(folder.string() + ": has neither poses.txt nor objects.csv");
  }
  for (const NumberedPose& pose : truth.poses) {
    if (!pose.finite()) throw InputError((folder / "poses.txt").string() + ": not all finite");
  }
  return truth;
}

Estimate read_result(const fs::path& folder) {
  require_folder(folder);
  Estimate estimate;
  const bool has_poses = fs::exists(folder / "poses.txt");
  const bool has_objects = fs::exists(folder / "objects.csv");
  if (!has_poses && !has_objects) {
    throw InputError(folder.string() +
                     ": has neither poses.txt nor objects.csv; egomod-log export writes them");
  }
  if (has_poses) estimate.poses = read_kitti(folder / "poses.txt");
  if (has_objects) estimate.detections = read_detections(folder / "objects.csv");
  if (fs::exists(folder / "timing.csv")) estimate.stage_ms = read_timing(folder / "timing.csv");
  return estimate;
}

Poses read_poses(const fs::path& file, PoseFormat format, const std::vector<double>& times_s) {
  return format == PoseFormat::kKitti ? read_kitti(file) : read_tum(file, times_s);
}

}  // namespace egomod::eval
