// SPDX-License-Identifier: Apache-2.0
#include "calibration_writer.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <fstream>
#include <string>

namespace egomod::sim {
namespace {

// Row by row.
void write_matrix(const std::string& key, const Eigen::MatrixXd& matrix, std::ostream& out) {
  fmt::print(out, "{}:", key);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    fmt::print(out, " {}", matrix(i / matrix.cols(), i % matrix.cols()));
  }
  fmt::print(out, "\n");
}

void write_camera(const std::string& suffix, const RawCamera& raw, const StereoCamera& rectified,
                  double baseline_m, std::ostream& out) {
  write_matrix("S_" + suffix, Eigen::RowVector2d(raw.width_px, raw.height_px), out);
  write_matrix("K_" + suffix, raw.K, out);
  write_matrix("D_" + suffix, Eigen::Map<const Eigen::RowVectorXd>(raw.distortion.data(), 5), out);
  write_matrix("S_rect_" + suffix, Eigen::RowVector2d(rectified.width_px, rectified.height_px),
               out);
  write_matrix("R_rect_" + suffix, raw.R_rectified_raw, out);
  Eigen::Matrix<double, 3, 4> P;
  P << rectified.fx_px, 0, rectified.cx_px, -rectified.fx_px * baseline_m,  //
      0, rectified.fy_px, rectified.cy_px, 0,                               //
      0, 0, 1, 0;
  write_matrix("P_rect_" + suffix, P, out);
}

}  // namespace

void write_raw_calibration(const Calibration& c, const std::filesystem::path& file) {
  std::ofstream out;
  out.exceptions(std::ios::badbit | std::ios::failbit);
  out.open(file);
  write_camera("00", c.left, c.camera, 0.0, out);
  write_camera("01", c.right, c.camera, c.camera.baseline_m, out);
  write_matrix("R_01", c.R_right_left, out);
  write_matrix("T_01", c.t_right_left_m.transpose(), out);
}

}  // namespace egomod::sim
