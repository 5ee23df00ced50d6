// SPDX-License-Identifier: Apache-2.0
#include "capture/calibration_message.hpp"

#include <algorithm>
#include <chrono>
#include <egomod/calibration_t.hpp>

#include "capture/image_message.hpp"

namespace egomod {
namespace {

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const double* values) {
  if constexpr (Columns == 1) {
    return Eigen::Map<const Eigen::Matrix<double, Rows, 1>>(values);
  } else {
    return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(values);
  }
}

RawCamera raw_camera(int width_px, int height_px, const double* K, const double* distortion,
                     const double* R_rectified_raw) {
  RawCamera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.K = matrix<3, 3>(K);
  std::copy_n(distortion, camera.distortion.size(), camera.distortion.begin());
  camera.R_rectified_raw = matrix<3, 3>(R_rectified_raw);
  return camera;
}

}  // namespace

std::optional<TimedCalibration> decode_calibration(std::span<const std::uint8_t> message) {
  calibration_t m;
  if (m.decode(message.data(), 0, static_cast<int>(message.size())) < 0) return std::nullopt;
  if (m.utime < -kMaxUtime_us || m.utime > kMaxUtime_us) return std::nullopt;
  TimedCalibration timed;
  timed.holds_from = std::chrono::microseconds(m.utime);
  Calibration& calibration = timed.calibration;
  calibration.camera = {.fx_px = m.fx,
                        .fy_px = m.fy,
                        .cx_px = m.cx,
                        .cy_px = m.cy,
                        .baseline_m = m.baseline,
                        .width_px = m.width,
                        .height_px = m.height};
  calibration.images_are_raw = m.images_are_raw != 0;
  calibration.left =
      raw_camera(m.left_width, m.left_height, m.left_K, m.left_distortion, m.left_R_rectified_raw);
  calibration.right = raw_camera(m.right_width, m.right_height, m.right_K, m.right_distortion,
                                 m.right_R_rectified_raw);
  calibration.R_right_left = matrix<3, 3>(m.R_right_left);
  calibration.t_right_left_m = matrix<3, 1>(m.t_right_left);
  calibration.T_body_camera.matrix().topRows<3>() = matrix<3, 4>(m.T_body_camera);
  return timed;
}

}  // namespace egomod
