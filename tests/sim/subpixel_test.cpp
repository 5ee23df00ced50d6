// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "capture/rectifier.hpp"
#include "egomod/core/geometry.hpp"
#include "image_formation.hpp"
#include "optics.hpp"
#include "spot_panel.hpp"

namespace egomod::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::SpotPanel;

constexpr double kSubpixel_px = 0.05;  // what the daemon's matching could ever notice
constexpr double kUnbiased_px = 0.01;
constexpr double kYaw_radps = 0.7;
constexpr double kReadout_s = 0.03;

RawCamera camera(const Distortion& lens) {
  RawCamera raw;
  raw.width_px = 320;
  raw.height_px = 240;
  raw.K << 262.5, 0, 161.3, 0, 262.5, 117.8, 0, 0, 1;
  raw.distortion = lens;
  return raw;
}

// Where the camera of these tests stands at an instant: it turns.
Isometry3d T_world_camera(double t_s) {
  Isometry3d T = Isometry3d::Identity();
  T.translate(Vector3d(0.031, -0.017, 0.0));
  T.rotate(Eigen::AngleAxisd(kYaw_radps * t_s, Vector3d::UnitY()) *
           Eigen::AngleAxisd(0.03, Vector3d::UnitZ()));
  return T;
}

Image render(const SpotPanel& panel, const RawCamera& raw, const Shutter& shutter) {
  StereoCamera truth;
  truth.width_px = truth.height_px = 64;
  truth.fx_px = truth.fy_px = 64.0;
  const Renderer renderer(panel.scene(), truth);
  const ImageFormation formation(raw, shutter);
  std::vector<View> views;
  for (const ImageFormation::Strip& strip : formation.strips()) {
    views.push_back({strip.offset_s, T_world_camera(strip.offset_s).inverse(), strip.first_view_row,
                     strip.end_view_row, strip.canvas_row});
  }
  const auto canvas =
      renderer.make_canvas(formation.pinhole().width_px, formation.canvas_height_px());
  renderer.draw(canvas, formation.pinhole(), views);
  Image drawn;
  Image picture;
  renderer.read(canvas, drawn);
  formation.develop(drawn, picture);
  return picture;
}

// The camera by definition: a row is exposed when the shutter comes to it.
test::ReferenceCamera reference(const RawCamera& raw, double readout_s) {
  const auto pose = [raw, readout_s](double v) {
    return T_world_camera(readout_s * (v - 0.5 * (raw.height_px - 1)) / raw.height_px);
  };
  test::ReferenceCamera out;
  out.centre_m = pose(0.0).translation();
  out.ray = [raw, pose](const Vector2d& pixel) {
    const Vector2d image((pixel.x() - raw.K(0, 2)) / raw.K(0, 0),
                         (pixel.y() - raw.K(1, 2)) / raw.K(1, 1));
    return Vector3d(pose(pixel.y()).linear() *
                    undistorted(raw.distortion, image).value().homogeneous());
  };
  out.pixel = [raw, pose](const Vector3d& P_world_m) {
    Vector2d pixel(0.0, 0.5 * raw.height_px);
    for (int i = 0; i < 5; ++i) {  // the row decides on the pose, and the pose on the row
      const Vector3d P = pose(pixel.y()).inverse() * P_world_m;
      const Vector2d image = distorted(raw.distortion, P.hnormalized());
      pixel = {raw.K(0, 0) * image.x() + raw.K(0, 2), raw.K(1, 1) * image.y() + raw.K(1, 2)};
    }
    return pixel;
  };
  return out;
}

void expect_subpixel(const RawCamera& raw, const Shutter& shutter, double largest_px) {
  for (const auto& [distance_m, turn_rad, lean_rad] :
       {std::tuple{1.6, 0.0, 0.0}, std::tuple{2.1, 0.6, 0.25}, std::tuple{2.8, -0.9, -0.3}}) {
    const SpotPanel panel(distance_m, turn_rad, lean_rad);
    const auto errors = test::summary_of(
        centroid_errors(render(panel, raw, shutter), panel, reference(raw, shutter.readout_s)));
    EXPECT_GT(errors.count, 25U);
    EXPECT_LT(errors.largest_px, largest_px) << "turned by " << turn_rad;
    EXPECT_LT(errors.mean_px.norm(), kUnbiased_px) << "turned by " << turn_rad;
    std::printf("[  figures ] %zu spots: rms %.4f, largest %.4f, mean (%.4f, %.4f) px\n",
                errors.count, errors.rms_px, errors.largest_px, errors.mean_px.x(),
                errors.mean_px.y());
  }
}

TEST(Subpixel, SpotsAreWhereGeometryPutsThem) { expect_subpixel(camera({}), {}, kSubpixel_px); }

TEST(Subpixel, SpotsSeenThroughALensAreWhereItBendsThem) {
  expect_subpixel(camera({-0.21, 0.06, 0.002, -0.0015, 0.0}), {}, kSubpixel_px);
  expect_subpixel(camera({0.18, -0.05, -0.001, 0.002, 0.01}), {}, kSubpixel_px);
}

// The two lens models know nothing of each other.
TEST(Subpixel, SpotsRectifiedByTheDaemonAreWhereAnIdealCameraSeesThem) {
  RawCamera raw = camera({-0.21, 0.06, 0.002, -0.0015, 0.0});
  raw.R_rectified_raw =
      (Eigen::AngleAxisd(0.02, Vector3d::UnitY()) * Eigen::AngleAxisd(-0.015, Vector3d::UnitX()) *
       Eigen::AngleAxisd(0.03, Vector3d::UnitZ()))
          .toRotationMatrix();
  const StereoCamera ideal{.fx_px = 300.0,
                           .fy_px = 300.0,
                           .cx_px = 159.5,
                           .cy_px = 119.5,
                           .baseline_m = 0.3,
                           .width_px = 320,
                           .height_px = 240};
  test::ReferenceCamera reference;
  const Isometry3d T_world_rectified =
      T_world_camera(0.0) * Isometry3d(raw.R_rectified_raw.transpose());
  reference.centre_m = T_world_rectified.translation();
  reference.ray = [&](const Vector2d& p) {
    return Vector3d(T_world_rectified.linear() * Vector3d((p.x() - ideal.cx_px) / ideal.fx_px,
                                                          (p.y() - ideal.cy_px) / ideal.fy_px, 1));
  };
  reference.pixel = [&](const Vector3d& P_world_m) {
    return Vector2d(project(ideal, T_world_rectified.inverse() * P_world_m).head<2>());
  };
  const SpotPanel panel(1.9, 0.4, 0.2);
  Image rectified;
  Rectifier(raw, ideal).apply(render(panel, raw, {}), rectified);
  const auto errors = test::summary_of(centroid_errors(rectified, panel, reference));
  EXPECT_GT(errors.count, 25U);
  EXPECT_LT(errors.largest_px, kSubpixel_px);
  EXPECT_LT(errors.mean_px.norm(), kUnbiased_px);
}

TEST(Subpixel, ARollingShutterMovesSpotsByWhatTheCameraTurned) {
  // Strips move in steps of this size; half of one is the error of their edges' rows.
  const double step_px = kYaw_radps * 262.5 * kReadout_s / 60.0;
  expect_subpixel(camera({}), {kReadout_s, 60}, kSubpixel_px + 0.5 * step_px);
  expect_subpixel(camera({-0.21, 0.06, 0.002, -0.0015, 0.0}), {kReadout_s, 60},
                  kSubpixel_px + 0.5 * step_px);
}

}  // namespace
}  // namespace egomod::sim
