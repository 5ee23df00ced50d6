// SPDX-License-Identifier: Apache-2.0
#include "capture/stereo_rectify.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "capture/lens.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/core/geometry.hpp"

namespace egomod {
namespace {

constexpr double kMinBaseline_m = 1e-6;
constexpr double kMinSideways = 0.7;  // cosine between baseline and x axis
constexpr double kMinFieldOfView = 0.05;
constexpr int kBorderSamples = 64;

// The part of the plane z = 1 of the rectified frame that a raw image sees for sure.
struct Window {
  double left = -std::numeric_limits<double>::infinity();
  double right = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
};

void narrow(Window& window, const RawCamera& camera) {
  const Lens lens(camera);
  const double right_px = camera.width_px - 1.0;
  const double bottom_px = camera.height_px - 1.0;
  const auto rectified = [&](double u_px, double v_px) -> Eigen::Vector2d {
    const Eigen::Vector3d x = camera.R_rectified_raw * lens.normalised({u_px, v_px}).homogeneous();
    return x.hnormalized();
  };
  for (int i = 0; i <= kBorderSamples; ++i) {
    const double part = static_cast<double>(i) / kBorderSamples;
    window.left = std::max(window.left, rectified(0.0, part * bottom_px).x());
    window.right = std::min(window.right, rectified(right_px, part * bottom_px).x());
    window.top = std::max(window.top, rectified(part * right_px, 0.0).y());
    window.bottom = std::min(window.bottom, rectified(part * right_px, bottom_px).y());
  }
}

void choose_rotations(Calibration& calibration, const std::string& where) {
  const Eigen::Vector3d half_rad = 0.5 * so3_log(calibration.R_right_left);
  const Eigen::Matrix3d R_left = so3_exp(half_rad);
  const Eigen::Matrix3d R_right = so3_exp(-half_rad);
  // The right camera's centre seen from the left one, in the axes that both share now.
  const Eigen::Vector3d baseline_m = -(R_right * calibration.t_right_left_m);
  if (!(baseline_m.norm() > kMinBaseline_m)) {
    throw SourceError(where + ": the two cameras are at the same place; check the extrinsics");
  }
  if (baseline_m.normalized().x() < kMinSideways) {
    throw SourceError(where + ": the right camera is not to the right of the left one; are they " +
                      "swapped, or the extrinsics inverted?");
  }
  const Eigen::Matrix3d R_common =
      Eigen::Quaterniond::FromTwoVectors(baseline_m, Eigen::Vector3d::UnitX()).toRotationMatrix();
  calibration.left.R_rectified_raw = R_common * R_left;
  calibration.right.R_rectified_raw = R_common * R_right;
  calibration.camera.baseline_m = baseline_m.norm();
}

}  // namespace

void choose_rectification(Calibration& calibration, const std::string& where) {
  choose_rotations(calibration, where);
  Window window;
  narrow(window, calibration.left);
  narrow(window, calibration.right);
  const double width = window.right - window.left;
  const double height = window.bottom - window.top;
  if (!(width > kMinFieldOfView && height > kMinFieldOfView)) {
    throw SourceError(where + ": the two cameras see nothing in common; check the extrinsics");
  }
  StereoCamera& camera = calibration.camera;
  camera.width_px = calibration.left.width_px;
  camera.height_px = calibration.left.height_px;
  const double f_px = std::max((camera.width_px - 1) / width, (camera.height_px - 1) / height);
  camera.fx_px = f_px;
  camera.fy_px = f_px;
  camera.cx_px = 0.5 * (camera.width_px - 1 - f_px * (window.left + window.right));
  camera.cy_px = 0.5 * (camera.height_px - 1 - f_px * (window.top + window.bottom));
  calibration.images_are_raw = true;
}

}  // namespace egomod
