// SPDX-License-Identifier: Apache-2.0
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "capture/calibration_check.hpp"
#include "capture/folder_contents.hpp"
#include "capture/stereo_rectify.hpp"
#include "capture/text_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

// The bus counts microseconds: nanoseconds are rounded to the nearest.
Nanoseconds read_stamp(const std::string& text, const std::string& where) {
  const long long stamp_ns = parse_integer(trimmed(text), where);
  if (stamp_ns < 0) throw SourceError(where + ": the time stamp is negative");
  return std::chrono::microseconds(stamp_ns / 1000 + (stamp_ns % 1000 >= 500 ? 1 : 0));
}

FolderContents::Camera list_camera(const fs::path& folder) {
  const fs::path table = folder / "data.csv";
  if (!fs::exists(table)) throw SourceError(table.string() + " is missing: it names the images");
  FolderContents::Camera camera;
  for (const auto& [number, text] : read_lines(table)) {
    if (text.starts_with('#')) continue;
    const std::string where = at(table, number);
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) throw SourceError(where + ": expected 'time_ns,file name'");
    const Nanoseconds exposure = read_stamp(text.substr(0, comma), where);
    if (!camera.exposures.empty() && exposure <= camera.exposures.back()) {
      throw SourceError(where + ": the time runs backwards or repeats; times must ascend by at " +
                        "least a microsecond");
    }
    const fs::path file = folder / "data" / trimmed(std::string_view(text).substr(comma + 1));
    if (!fs::is_regular_file(file)) {
      throw SourceError(where + ": the image " + shown(file.string()) + " is missing");
    }
    camera.exposures.push_back(exposure);
    camera.files.push_back(file);
  }
  if (camera.files.empty()) throw SourceError(table.string() + ": names no images");
  return camera;
}

class SensorFile {
 public:
  explicit SensorFile(const fs::path& file) : file_(file) {
    if (!fs::exists(file)) {
      throw SourceError(file.string() + " is missing: add it, or name a rig file with --rig");
    }
    try {
      root_ = YAML::LoadFile(file.string());
    } catch (const YAML::Exception& problem) {
      throw SourceError(at(file, problem.mark.line + 1) + ": " + problem.msg);
    }
    if (!root_.IsMap()) throw SourceError(file.string() + ": is not a map of keys");
  }

  [[nodiscard]] YAML::Node node(const std::string& key) const {
    const YAML::Node found = root_[key];
    if (!found) throw SourceError(file_.string() + ": the key '" + key + "' is missing");
    return found;
  }

  [[nodiscard]] std::vector<double> numbers(const YAML::Node& node, const std::string& key,
                                            std::size_t count) const {
    const std::string where = at(file_, node.Mark().line + 1) + ": " + key;
    try {
      auto values = node.as<std::vector<double>>();
      if (values.size() != count) {
        throw SourceError(where + ": has " + std::to_string(values.size()) + " numbers, needs " +
                          std::to_string(count));
      }
      for (const double value : values) {
        if (!std::isfinite(value)) throw SourceError(where + ": holds a number that is not finite");
      }
      return values;
    } catch (const YAML::Exception&) {
      throw SourceError(where + ": is not a list of numbers");
    }
  }

  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const {
    return numbers(node(key), key, count);
  }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw SourceError(at(file_, node(key).Mark().line + 1) + ": " + key + ": " + what);
  }

  void require_radial_tangential() const {
    const YAML::Node found = root_["distortion_model"];
    const std::string model = found && found.IsScalar() ? found.as<std::string>() : "";
    if (model == "radial-tangential" || model == "radtan") return;
    throw SourceError(file_.string() + ": distortion_model '" + shown(model) +
                      "' is not supported; radial-tangential is");
  }

  [[nodiscard]] Eigen::Isometry3d T_BS() const {
    const YAML::Node data = node("T_BS").IsMap() ? node("T_BS")["data"] : node("T_BS");
    if (!data) throw SourceError(file_.string() + ": T_BS has no 'data'");
    const std::vector<double> values = numbers(data, "T_BS", 16);
    Eigen::Isometry3d T;
    T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    if (!is_rigid_transform(T.matrix())) fail("T_BS", "is not a rigid transform");
    return T;
  }

 private:
  fs::path file_;
  YAML::Node root_;
};

RawCamera read_camera(const SensorFile& sensor) {
  sensor.require_radial_tangential();
  const auto size = sensor.numbers("resolution", 2);
  const auto K = sensor.numbers("intrinsics", 4);
  const auto D = sensor.numbers("distortion_coefficients", 4);
  if (!is_image_size(size[0], size[1])) sensor.fail("resolution", "is not an image size");
  RawCamera camera;
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  if (!is_focal_length(K[0], camera.width_px) || !is_focal_length(K[1], camera.height_px)) {
    sensor.fail("intrinsics", std::string("focal lengths ") + kFocalLengthRule);
  }
  if (!is_principal_point(K[2], camera.width_px) || !is_principal_point(K[3], camera.height_px)) {
    sensor.fail("intrinsics", std::string("the principal point ") + kPrincipalPointRule);
  }
  if (!is_distortion(D)) sensor.fail("distortion_coefficients", kDistortionRule);
  camera.K << K[0], 0, K[2], 0, K[1], K[3], 0, 0, 1;
  camera.distortion = {D[0], D[1], D[2], D[3], 0.0};
  return camera;
}

Calibration read_calibration(const fs::path& mav0) {
  const SensorFile left(mav0 / "cam0" / "sensor.yaml");
  const SensorFile right(mav0 / "cam1" / "sensor.yaml");
  Calibration calibration;
  calibration.left = read_camera(left);
  calibration.right = read_camera(right);
  const Eigen::Isometry3d T_right_left = right.T_BS().inverse() * left.T_BS();
  calibration.R_right_left = T_right_left.linear();
  calibration.t_right_left_m = T_right_left.translation();
  if (!is_baseline(calibration.t_right_left_m.norm())) {
    right.fail("T_BS",
               std::string("with cam0's it gives the distance between the cameras, which ") +
                   kBaselineRule);
  }
  choose_rectification(calibration, mav0.string() + "/cam0 and cam1");
  return calibration;
}

}  // namespace

FolderContents read_euroc_folder(const fs::path& mav0, bool rig_file_given) {
  FolderContents contents;
  contents.is_paired_by_index = false;
  contents.calibration_file = mav0.string() + "/cam0/sensor.yaml and cam1/sensor.yaml";
  if (!rig_file_given) contents.calibration = read_calibration(mav0);
  contents.left = list_camera(mav0 / "cam0");
  contents.right = list_camera(mav0 / "cam1");
  return contents;
}

}  // namespace egomod
