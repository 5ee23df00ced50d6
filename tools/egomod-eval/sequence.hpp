// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace egomod::eval {

// Inclusive, in pixels of the rectified left image.
struct Rectangle {
  double u_min_px = 0.0, v_min_px = 0.0, u_max_px = 0.0, v_max_px = 0.0;

  [[nodiscard]] bool contains(double u_px, double v_px) const {
    return u_px >= u_min_px && u_px <= u_max_px && v_px >= v_min_px && v_px <= v_max_px;
  }
};

// What the truth says of one object in one pair. Left camera frame; velocity relative to the static
// world, in left camera axes, at the visible surface's centroid.
struct TruthObject {
  std::string id;
  std::string type;
  double time_s = 0.0;
  Eigen::Vector3d surface_m{0.0, 0.0, 0.0};  // centroid of the visible surface
  Eigen::Vector3d centre_m{0.0, 0.0, 0.0};
  Eigen::Vector3d velocity_mps{0.0, 0.0, 0.0};
  Rectangle rectangle;
  int visible_px = 0;
  bool moving = false;
};

// One reported object in one pair; frames as above.
struct Detection {
  std::string track;
  double time_s = 0.0;  // NaN where unknown
  Eigen::Vector3d position_m{0.0, 0.0, 0.0};
  Eigen::Vector3d velocity_mps{0.0, 0.0, 0.0};
  Rectangle rectangle;
  // From a record only; left camera axes.
  std::optional<Eigen::Matrix3d> position_covariance_m2;
  std::optional<Eigen::Matrix3d> velocity_covariance_m2ps2;
  std::optional<double> speed_sigma_mps;
};

// Left camera to world.
struct NumberedPose {
  int frame = 0;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();

  [[nodiscard]] bool finite() const { return T_world_camera.matrix().allFinite(); }
};
using Poses = std::vector<NumberedPose>;
template <typename Object>
using ByFrame = std::map<int, std::vector<Object>>;

struct Truth {
  std::string name;
  std::filesystem::path folder;
  std::vector<double> times_s;
  Poses poses;                                  // empty: unknown
  std::optional<ByFrame<TruthObject>> objects;  // nothing: unknown
  double focal_px = 0.0;                        // read where objects are
  double cx_px = 0.0;
  double cy_px = 0.0;
  double baseline_m = 0.0;

  [[nodiscard]] int frames() const { return static_cast<int>(times_s.size()); }
  [[nodiscard]] double rate_hz() const;
};

// The time that all stages together take for a pair, of those that were processed.
constexpr const char* kAllStages = "sum of all stages";

struct Estimate {
  Poses poses;
  std::optional<ByFrame<Detection>> detections;  // nothing: not recorded
  std::map<std::string, std::vector<double>> stage_ms;
};

enum class PoseFormat { kKitti, kTum };

// A folder with times.txt and what there is of poses.txt, objects.csv with calib.txt. Throws
// InputError.
[[nodiscard]] Truth read_truth(const std::filesystem::path& folder);
// What `egomod-log export` writes: poses.txt, objects.csv, timing.csv, as far as they are there.
[[nodiscard]] Estimate read_result(const std::filesystem::path& folder);
// KITTI: 12 numbers a row, or 13 with the frame first. TUM: timestamp tx ty tz qx qy qz qw, each
// taken for the nearest frame of `times_s`, where there is one within half an interval.
[[nodiscard]] Poses read_poses(const std::filesystem::path& file, PoseFormat format,
                               const std::vector<double>& times_s);

}  // namespace egomod::eval
