// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "all_finite.hpp"
#include "egomod/publish/messages.hpp"

namespace egomod {
namespace {

using RowMajor33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

void write(const Eigen::Matrix3d& from, double (&to)[9]) {
  Eigen::Map<RowMajor33>(static_cast<double*>(to)) = from;
}

Eigen::Matrix3d read(const double (&from)[9]) {
  return Eigen::Map<const RowMajor33>(static_cast<const double*>(from));
}

void write_rectified(const StereoCamera& camera, calibration_t& message) {
  message.width = camera.width_px;
  message.height = camera.height_px;
  message.fx = camera.fx_px;
  message.fy = camera.fy_px;
  message.cx = camera.cx_px;
  message.cy = camera.cy_px;
  message.baseline = camera.baseline_m;
}

void write_raw(const Calibration& calibration, calibration_t& message) {
  const RawCamera& left = calibration.left;
  const RawCamera& right = calibration.right;
  message.left_width = left.width_px;
  message.left_height = left.height_px;
  write(left.K, message.left_K);
  std::copy(left.distortion.begin(), left.distortion.end(), message.left_distortion);
  write(left.R_rectified_raw, message.left_R_rectified_raw);
  message.right_width = right.width_px;
  message.right_height = right.height_px;
  write(right.K, message.right_K);
  std::copy(right.distortion.begin(), right.distortion.end(), message.right_distortion);
  write(right.R_rectified_raw, message.right_R_rectified_raw);
  write(calibration.R_right_left, message.R_right_left);
  Eigen::Vector3d::Map(message.t_right_left) = calibration.t_right_left_m;
}

void read_raw(const calibration_t& message, Calibration& calibration) {
  RawCamera& left = calibration.left;
  left.width_px = message.left_width;
  left.height_px = message.left_height;
  left.K = read(message.left_K);
  std::copy(std::begin(message.left_distortion), std::end(message.left_distortion),
            left.distortion.begin());
  left.R_rectified_raw = read(message.left_R_rectified_raw);
  RawCamera& right = calibration.right;
  right.width_px = message.right_width;
  right.height_px = message.right_height;
  right.K = read(message.right_K);
  std::copy(std::begin(message.right_distortion), std::end(message.right_distortion),
            right.distortion.begin());
  right.R_rectified_raw = read(message.right_R_rectified_raw);
  calibration.R_right_left = read(message.R_right_left);
  calibration.t_right_left_m = Eigen::Vector3d::Map(message.t_right_left);
}

}  // namespace

void fill_message(const Calibration& calibration, bool images_are_raw, calibration_t& message) {
  write_rectified(calibration.camera, message);
  message.images_are_raw = images_are_raw ? 1 : 0;
  write_raw(calibration, message);
  Eigen::Map<RowMajor34>(static_cast<double*>(message.T_body_camera)) =
      calibration.T_body_camera.matrix().topRows<3>();
}

Calibration calibration_from(const calibration_t& message) {
  Calibration calibration;
  calibration.camera = {.fx_px = message.fx,
                        .fy_px = message.fy,
                        .cx_px = message.cx,
                        .cy_px = message.cy,
                        .baseline_m = message.baseline,
                        .width_px = message.width,
                        .height_px = message.height};
  calibration.images_are_raw = message.images_are_raw != 0;
  read_raw(message, calibration);
  calibration.T_body_camera.matrix().topRows<3>() =
      Eigen::Map<const RowMajor34>(static_cast<const double*>(message.T_body_camera));
  return calibration;
}

bool is_finite(const calibration_t& message) {
  const double rectified[] = {message.fx, message.fy, message.cx, message.cy, message.baseline};
  return all_finite(rectified) && all_finite(message.left_K) &&
         all_finite(message.left_distortion) && all_finite(message.left_R_rectified_raw) &&
         all_finite(message.right_K) && all_finite(message.right_distortion) &&
         all_finite(message.right_R_rectified_raw) && all_finite(message.R_right_left) &&
         all_finite(message.t_right_left) && all_finite(message.T_body_camera);
}

}  // namespace egomod
