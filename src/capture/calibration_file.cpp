// SPDX-License-Identifier: Apache-2.0
#include "capture/calibration_file.hpp"

#include <cmath>
#include <map>

#include "capture/calibration_check.hpp"
#include "capture/text_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

constexpr double kSameIntrinsics_px = 1e-3;
constexpr double kMaxOffAxisBaseline = 0.01;  // of the baseline: rows would differ by more
constexpr double kSameBaseline = 0.02;  // of its length: as printed, and some trouble to spare

struct Entry {
  int line = 0;
  std::string text;
};

// "key: values" lines. Values stay text, since some keys of KITTI hold dates.
class KeyedFile {
 public:
  explicit KeyedFile(const std::filesystem::path& file) : file_(file) {
    for (const auto& [number, text] : read_lines(file)) {
      const std::size_t colon = text.find(':');
      if (colon == std::string::npos) {
        throw SourceError(at(file, number) + ": expected 'key: values', found '" + shown(text) +
                          "'");
      }
      const std::string key(trimmed(text.substr(0, colon)));
      if (!entries_.emplace(key, Entry{number, text.substr(colon + 1)}).second) {
        throw SourceError(at(file, number) + ": key '" + shown(key) + "' is given twice");
      }
    }
  }

  [[nodiscard]] std::string where(const std::string& key) const {
    return at(file_, entry(key).line) + ": " + key;
  }

  // Row-major.
  template <int Rows, int Columns>
  [[nodiscard]] Eigen::Matrix<double, Rows, Columns> matrix(const std::string& key) const {
    const std::vector<double> numbers = parse_numbers(entry(key).text, where(key));
    if (numbers.size() != Rows * Columns) {
      throw SourceError(where(key) + ": has " + std::to_string(numbers.size()) +
                        " numbers, needs " + std::to_string(Rows * Columns));
    }
    Eigen::Matrix<double, Rows, Columns> matrix;
    for (int i = 0; i < Rows * Columns; ++i) {
      matrix(i / Columns, i % Columns) = numbers[static_cast<std::size_t>(i)];
    }
    return matrix;
  }

 private:
  [[nodiscard]] const Entry& entry(const std::string& key) const {
    const auto found = entries_.find(key);
    if (found == entries_.end()) {
      throw SourceError(file_.string() + ": the line '" + key + ": ...' is missing");
    }
    return found->second;
  }

  std::filesystem::path file_;
  std::map<std::string, Entry> entries_;
};

std::string number(double value) { return std::to_string(value); }

void require_same(double left, double right, const char* what, const std::string& where) {
  if (std::abs(left - right) <= kSameIntrinsics_px) return;
  throw SourceError(where + ": not a rectified pair: " + what + " is " + number(left) +
                    " px on the left and " + number(right) +
                    " px on the right; rectify both images with one common camera matrix");
}

}  // namespace

StereoCamera rectified_camera(const Matrix34d& P_left, const Matrix34d& P_right,
                              const std::string& where) {
  if (!P_left.allFinite() || !P_right.allFinite()) throw SourceError(where + ": is not finite");
  StereoCamera camera;
  camera.fx_px = P_left(0, 0);
  camera.fy_px = P_left(1, 1);
  camera.cx_px = P_left(0, 2);
  camera.cy_px = P_left(1, 2);
  // The image's size is not known yet.
  if (!is_focal_length(camera.fx_px, 0) || !is_focal_length(camera.fy_px, 0)) {
    throw SourceError(where + ": focal lengths " + kFocalLengthRule);
  }
  if (!is_principal_point(camera.cx_px, 0) || !is_principal_point(camera.cy_px, 0)) {
    throw SourceError(where + ": the principal point " + kPrincipalPointRule);
  }
  for (const Matrix34d* P : {&P_left, &P_right}) {
    const bool is_plain = (*P)(0, 1) == 0.0 && (*P)(1, 0) == 0.0 &&
                          P->block<1, 3>(2, 0) == Eigen::RowVector3d(0.0, 0.0, 1.0);
    if (!is_plain)
      throw SourceError(where + ": must have the form [fx 0 cx tx; 0 fy cy ty; 0 0 1 tz]");
  }
  require_same(camera.fx_px, P_right(0, 0), "fx", where);
  require_same(camera.fy_px, P_right(1, 1), "fy", where);
  require_same(camera.cx_px, P_right(0, 2), "cx", where);
  require_same(camera.cy_px, P_right(1, 2), "cy", where);
  const Eigen::Vector3d t = P_left.col(3) - P_right.col(3);
  camera.baseline_m = t.x() / camera.fx_px;
  if (!(camera.baseline_m > 0.0)) {
    throw SourceError(where + ": baseline " + number(camera.baseline_m) +
                      " m is not positive; are left and right swapped?");
  }
  if (!is_baseline(camera.baseline_m)) {
    throw SourceError(where + ": the baseline, " + number(camera.baseline_m) + " m, " +
                      kBaselineRule + "; the fourth column counts pixels times metres");
  }
  const double off_axis_m = std::hypot(t.y() / camera.fy_px, t.z());
  if (off_axis_m > kMaxOffAxisBaseline * camera.baseline_m) {
    throw SourceError(where + ": not a rectified pair: the right camera is " + number(off_axis_m) +
                      " m off the left one's x axis");
  }
  return camera;
}

Calibration read_kitti_calibration(const std::filesystem::path& file) {
  const KeyedFile keyed(file);
  const Matrix34d P0 = keyed.matrix<3, 4>("P0");
  const Matrix34d P1 = keyed.matrix<3, 4>("P1");
  Calibration calibration;
  calibration.camera = rectified_camera(P0, P1, keyed.where("P0") + " and P1");
  return calibration;
}

namespace {

Eigen::Vector2i read_size(const KeyedFile& keyed, const std::string& key) {
  const Eigen::Vector2d size = keyed.matrix<2, 1>(key);
  if (!is_image_size(size.x(), size.y())) {
    throw SourceError(keyed.where(key) + ": is not an image size");
  }
  return size.cast<int>();
}

Eigen::Matrix3d read_rotation(const KeyedFile& keyed, const std::string& key) {
  Eigen::Matrix3d R = keyed.matrix<3, 3>(key);
  if (!is_rotation(R)) throw SourceError(keyed.where(key) + ": is not a rotation");
  return R;
}

RawCamera read_raw_camera(const KeyedFile& keyed, const std::string& suffix) {
  RawCamera camera;
  const Eigen::Vector2i size = read_size(keyed, "S_" + suffix);
  camera.width_px = size.x();
  camera.height_px = size.y();
  camera.K = keyed.matrix<3, 3>("K_" + suffix);
  if (!is_camera_matrix(camera.K)) {
    throw SourceError(keyed.where("K_" + suffix) + ": must be [fx s cx; 0 fy cy; 0 0 1]");
  }
  if (!is_focal_length(camera.K(0, 0), size.x()) || !is_focal_length(camera.K(1, 1), size.y())) {
    throw SourceError(keyed.where("K_" + suffix) + ": focal lengths " + kFocalLengthRule);
  }
  if (!is_principal_point(camera.K(0, 2), size.x()) ||
      !is_principal_point(camera.K(1, 2), size.y())) {
    throw SourceError(keyed.where("K_" + suffix) + ": the principal point " + kPrincipalPointRule);
  }
  const Eigen::Matrix<double, 5, 1> D = keyed.matrix<5, 1>("D_" + suffix);
  Eigen::Map<Eigen::Matrix<double, 5, 1>>(camera.distortion.data()) = D;
  if (!is_distortion(camera.distortion)) {
    throw SourceError(keyed.where("D_" + suffix) + ": " + kDistortionRule);
  }
  camera.R_rectified_raw = read_rotation(keyed, "R_rect_" + suffix);
  return camera;
}

// The right camera's centre lies on the x axis of the rectified left one, a baseline away.
void require_same_baseline(const Calibration& calibration, const KeyedFile& keyed) {
  const Eigen::Vector3d centre_m =
      -(calibration.R_right_left.transpose() * calibration.t_right_left_m);
  const Eigen::Vector3d rectified_m = calibration.left.R_rectified_raw * centre_m;
  const double baseline_m = calibration.camera.baseline_m;
  if ((rectified_m - Eigen::Vector3d(baseline_m, 0.0, 0.0)).norm() <= kSameBaseline * baseline_m) {
    return;
  }
  throw SourceError(
      keyed.where("T_01") + ": with R_01 and R_rect_00 it places the right camera at (" +
      number(rectified_m.x()) + ", " + number(rectified_m.y()) + ", " + number(rectified_m.z()) +
      ") m, P_rect_01 at (" + number(baseline_m) + ", 0, 0) m; one of them is wrong");
}

}  // namespace

Calibration read_kitti_raw_calibration(const std::filesystem::path& file) {
  const KeyedFile keyed(file);
  Calibration calibration;
  calibration.images_are_raw = true;
  calibration.left = read_raw_camera(keyed, "00");
  calibration.right = read_raw_camera(keyed, "01");
  calibration.R_right_left = read_rotation(keyed, "R_01");
  calibration.t_right_left_m = keyed.matrix<3, 1>("T_01");
  calibration.camera =
      rectified_camera(keyed.matrix<3, 4>("P_rect_00"), keyed.matrix<3, 4>("P_rect_01"),
                       keyed.where("P_rect_00") + " and P_rect_01");
  const Eigen::Vector2i size = read_size(keyed, "S_rect_00");
  if (size != read_size(keyed, "S_rect_01")) {
    throw SourceError(keyed.where("S_rect_01") + ": differs from S_rect_00");
  }
  calibration.camera.width_px = size.x();
  calibration.camera.height_px = size.y();
  require_same_baseline(calibration, keyed);
  return calibration;
}

}  // namespace egomod
