// SPDX-License-Identifier: Apache-2.0
#include "capture/rig_file.hpp"

#include <toml++/toml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <vector>

#include "capture/calibration_check.hpp"
#include "capture/stereo_rectify.hpp"
#include "capture/text_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

// One table of the file, with its name for messages.
class Table {
 public:
  Table(const toml::table& table, std::string name, const std::string& file)
      : table_(table), name_(std::move(name)), file_(file) {}

  void allow_only(std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, node] : table_) {
      if (std::find(keys.begin(), keys.end(), key.str()) != keys.end()) continue;
      fail(std::string(key.str()), node, "is not a key of a rig file");
    }
  }

  [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }

  [[nodiscard]] Table table(std::string_view key) const {
    const toml::node& found = node(key);
    if (!found.is_table()) fail(std::string(key), found, "must be a table");
    return {*found.as_table(), full_name(std::string(key)), file_};
  }

  [[nodiscard]] double number(std::string_view key) const {
    return finite(node(key), std::string(key));
  }

  [[nodiscard]] std::vector<double> numbers(std::string_view key, std::size_t count) const {
    const toml::node& found = node(key);
    const toml::array* array = found.as_array();
    if (array == nullptr || array->size() != count) {
      fail(std::string(key), found, "must be a list of " + std::to_string(count) + " numbers");
    }
    std::vector<double> values;
    for (const toml::node& element : *array) values.push_back(finite(element, std::string(key)));
    return values;
  }

  [[nodiscard]] std::vector<int> size(std::string_view key) const {
    std::vector<int> sides;
    for (const double side : numbers(key, 2)) {
      if (side != std::floor(side) || std::abs(side) > 1e6) {
        fail(std::string(key), node(key), "must be [width, height] in pixels");
      }
      sides.push_back(static_cast<int>(side));
    }
    return sides;
  }

  [[noreturn]] void fail(std::string_view key, const std::string& what) const {
    fail(std::string(key), node(key), what);
  }

  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& what) const {
    throw SourceError(at(file_, static_cast<int>(node.source().begin.line)) + ": " +
                      full_name(key) + " " + what);
  }

 private:
  [[nodiscard]] std::string full_name(const std::string& key) const {
    return name_.empty() ? key : name_ + "." + key;
  }

  [[nodiscard]] const toml::node& node(std::string_view key) const {
    const toml::node* found = table_.get(key);
    if (found != nullptr) return *found;
    fail(std::string(key), table_, "is missing");
  }

  [[nodiscard]] double finite(const toml::node& node, const std::string& key) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value) || node.is_boolean()) fail(key, node, "must be a number");
    return *value;
  }

  const toml::table& table_;
  std::string name_;
  const std::string& file_;
};

Eigen::Matrix3d rotation_rpy(double roll_rad, double pitch_rad, double yaw_rad) {
  return (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

// Either a 4x4 `matrix`, row by row, or `translation_m` with `rpy_rad`, which turns the default
// pose of a camera: all zeros look along the body's x axis.
Eigen::Isometry3d read_T_body_camera(const Table& table) {
  table.allow_only({"matrix", "translation_m", "rpy_rad"});
  Eigen::Isometry3d T = default_T_body_camera();
  if (table.has("matrix")) {
    const auto values = table.numbers("matrix", 16);
    T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    if (!is_rigid_transform(T.matrix())) table.fail("matrix", "is not a rigid transform");
    return T;
  }
  const auto t = table.numbers("translation_m", 3);
  const auto rpy = table.numbers("rpy_rad", 3);
  T.linear() = rotation_rpy(rpy[0], rpy[1], rpy[2]) * T.linear();
  T.translation() = Eigen::Vector3d(t[0], t[1], t[2]);
  return T;
}

void require_pinhole(const Table& table) {
  const auto size = table.size("size_px");
  if (!is_image_size(size[0], size[1])) table.fail("size_px", "is not an image size");
  if (!is_focal_length(table.number("fx_px"), size[0])) table.fail("fx_px", kFocalLengthRule);
  if (!is_focal_length(table.number("fy_px"), size[1])) table.fail("fy_px", kFocalLengthRule);
  if (!is_principal_point(table.number("cx_px"), size[0])) table.fail("cx_px", kPrincipalPointRule);
  if (!is_principal_point(table.number("cy_px"), size[1])) table.fail("cy_px", kPrincipalPointRule);
}

// Row by row.
Eigen::Matrix3d read_rotation(const Table& table, std::string_view key) {
  const auto values = table.numbers(key, 9);
  Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  if (!is_rotation(R)) table.fail(key, "is not a rotation");
  return R;
}

StereoCamera read_rectified(const Table& table) {
  table.allow_only({"size_px", "fx_px", "fy_px", "cx_px", "cy_px", "baseline_m"});
  require_pinhole(table);
  if (!is_baseline(table.number("baseline_m"))) table.fail("baseline_m", kBaselineRule);
  const auto size = table.size("size_px");
  return {.fx_px = table.number("fx_px"),
          .fy_px = table.number("fy_px"),
          .cx_px = table.number("cx_px"),
          .cy_px = table.number("cy_px"),
          .baseline_m = table.number("baseline_m"),
          .width_px = size[0],
          .height_px = size[1]};
}

RawCamera read_raw(const Table& table) {
  table.allow_only(
      {"size_px", "fx_px", "fy_px", "cx_px", "cy_px", "distortion", "R_rectified_raw"});
  require_pinhole(table);
  RawCamera camera;
  const auto size = table.size("size_px");
  camera.width_px = size[0];
  camera.height_px = size[1];
  camera.K << table.number("fx_px"), 0, table.number("cx_px"), 0, table.number("fy_px"),
      table.number("cy_px"), 0, 0, 1;
  const auto D = table.numbers("distortion", 5);
  if (!is_distortion(D)) table.fail("distortion", kDistortionRule);
  std::copy(D.begin(), D.end(), camera.distortion.begin());
  if (table.has("R_rectified_raw")) {
    camera.R_rectified_raw = read_rotation(table, "R_rectified_raw");
  }
  return camera;
}

void read_extrinsics(const Table& table, Calibration& calibration) {
  table.allow_only({"rotation", "translation_m"});
  calibration.R_right_left = read_rotation(table, "rotation");
  const auto t = table.numbers("translation_m", 3);
  calibration.t_right_left_m = Eigen::Vector3d(t[0], t[1], t[2]);
  if (!is_baseline(calibration.t_right_left_m.norm())) {
    table.fail("translation_m",
               std::string("is the distance between the cameras and ") + kBaselineRule);
  }
}

void read_raw_rig(const Table& root, Calibration& calibration, const std::string& file) {
  calibration.images_are_raw = true;
  calibration.left = read_raw(root.table("left"));
  calibration.right = read_raw(root.table("right"));
  read_extrinsics(root.table("right_from_left"), calibration);
  const bool is_rectification_given = root.has("rectified");
  for (const char* side : {"left", "right"}) {
    if (root.table(side).has("R_rectified_raw") == is_rectification_given) continue;
    throw SourceError(file + ": " + side + ".R_rectified_raw and [rectified] belong together: " +
                      "give all three of them, or none to have them chosen");
  }
  if (is_rectification_given) {
    calibration.camera = read_rectified(root.table("rectified"));
  } else {
    choose_rectification(calibration, file);
  }
}

toml::table parse(const std::string& file) {
  std::ifstream stream(file);
  if (!stream || !std::filesystem::is_regular_file(file)) {
    throw SourceError(file + ": is not a file that can be read; name a rig file with --rig");
  }
  try {
    return toml::parse(stream, file);
  } catch (const toml::parse_error& problem) {
    throw SourceError(at(file, static_cast<int>(problem.source().begin.line)) + ": " +
                      std::string(problem.description()));
  }
}

}  // namespace

Calibration read_rig_file(const std::string& file) {
  const toml::table parsed = parse(file);
  const Table root(parsed, "", file);
  root.allow_only({"rectified", "left", "right", "right_from_left", "T_body_camera"});
  Calibration calibration;
  const bool is_raw = root.has("left") || root.has("right") || root.has("right_from_left");
  if (is_raw) {
    read_raw_rig(root, calibration, file);
  } else {
    calibration.camera = read_rectified(root.table("rectified"));
  }
  if (root.has("T_body_camera")) {
    calibration.T_body_camera = read_T_body_camera(root.table("T_body_camera"));
  }
  if (const std::string fault = fault_of(calibration); !fault.empty()) {
    throw SourceError(file + ": " + fault + "; correct the rig file");
  }
  return calibration;
}

}  // namespace egomod
