// SPDX-License-Identifier: Apache-2.0
#include "camera_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace egomod::sim {
namespace {

constexpr double kMaxTilt_deg = 20.0;
constexpr double kMaxCoefficient = 10.0;
constexpr double kMaxOverhang_px = 0.5;
constexpr double kMaxJitter = 0.15;  // of the frame interval: exposures stay in order

CameraBuild ideal(const StereoCamera& c) {
  return {.focal_px = c.fx_px, .cx_px = c.cx_px, .cy_px = c.cy_px};
}

void read_build(TableReader& in, const StereoCamera& rectified, CameraBuild& build) {
  build.focal_px = in.number("focal_px", build.focal_px, 10.0, 10000.0);
  build.cx_px = in.number("cx_px", build.cx_px, 0.0, rectified.width_px);
  build.cy_px = in.number("cy_px", build.cy_px, 0.0, rectified.height_px);
  build.yaw_rad = degrees(in, "yaw_deg", kMaxTilt_deg);
  build.pitch_rad = degrees(in, "pitch_deg", kMaxTilt_deg);
  build.roll_rad = degrees(in, "roll_deg", kMaxTilt_deg);
  const auto k = in.numbers("distortion", 5, -kMaxCoefficient, kMaxCoefficient, {0, 0, 0, 0, 0});
  std::copy(k.begin(), k.end(), build.distortion.begin());
}

void check_build(TableReader& in, const World& world, Eye eye) {
  const Calibration written = written_calibration(world.camera, world.optics);
  const RawCamera& raw = eye == Eye::kLeft ? written.left : written.right;
  if (!is_invertible(raw)) {
    in.fail("distortion", "the lens folds back within the image: some pixel shows two directions");
  }
  const double overhang = overhang_px(world.camera, raw);
  if (overhang > kMaxOverhang_px) {
    in.fail("focal_px",
            fmt::format("the rectified image reaches {:.1f} px beyond this raw one: lower this, or "
                        "raise camera.focal_px",
                        overhang));
  }
}

void read_raw_camera(TableReader& in, const std::string& key, Eye eye, World& world) {
  in.table(key, [&](TableReader& table) {
    world.optics.images_are_raw = true;
    read_build(table, world.camera, eye == Eye::kLeft ? world.optics.left : world.optics.right);
    check_build(table, world, eye);
  });
}

double interval_s(const World& world) { return 1.0 / world.rate_hz; }

}  // namespace

double degrees(TableReader& in, const std::string& key, double limit_deg) {
  return in.number(key, 0.0, -limit_deg, limit_deg) * kRadPerDeg;
}

void read_camera(TableReader& in, World& world) {
  StereoCamera& camera = world.camera;
  camera.width_px = in.integer("width_px", 640, 64, 4096);
  camera.height_px = in.integer("height_px", 480, 64, 4096);
  camera.fx_px = in.number("focal_px", 525.0 * camera.width_px / 640.0, 10.0, 10000.0);
  camera.fy_px = camera.fx_px;
  camera.cx_px = in.number("cx_px", 0.5 * (camera.width_px - 1), 0.0, camera.width_px);
  camera.cy_px = in.number("cy_px", 0.5 * (camera.height_px - 1), 0.0, camera.height_px);
  camera.baseline_m = in.number("baseline_m", 0.375, 0.001, 10.0);
  world.rate_hz = in.number("rate_hz", 30.0, 0.1, 1000.0);
  world.optics.left = ideal(camera);
  world.optics.right = ideal(camera);
  read_raw_camera(in, "left", Eye::kLeft, world);
  read_raw_camera(in, "right", Eye::kRight, world);
}

void read_realism(TableReader& in, World& world) {
  Realism& r = world.realism;
  r.softness_px = in.number("softness_px", r.softness_px, 0.0, 0.7);
  r.read_noise = in.number("read_noise", r.read_noise, 0.0, 50.0);
  r.shot_noise = in.number("shot_noise", r.shot_noise, 0.0, 5.0);
  r.vignetting = in.number("vignetting", r.vignetting, 0.0, 0.9);
  r.right_gain = in.number("right_gain", r.right_gain, 0.2, 5.0);
  r.gain_drift = in.number("gain_drift", r.gain_drift, 0.0, 0.5);
  r.gain_drift_period_s = in.number("gain_drift_period_s", r.gain_drift_period_s, 0.1, 1e4);
  r.exposure_s = in.number("exposure_s", r.exposure_s, 0.0, 1.0);
  r.blur_samples = in.integer("blur_samples", r.blur_samples, 1, 64);
  r.readout_s = in.number("readout_s", r.readout_s, 0.0, 1.0);
  r.readout_strips = in.integer("readout_strips", r.readout_strips, 2, 4096);
  if (r.exposure_s > 0.0 && r.blur_samples == 1) {
    in.fail("exposure_s", "blurs only with blur_samples of 2 or more");
  }
  if (r.blur_samples > 1 && r.exposure_s <= 0.0) in.fail("blur_samples", "needs exposure_s");
  if (in.has("readout_strips") && r.readout_s <= 0.0) {
    in.fail("readout_strips", "needs readout_s");
  }
  for (const auto& [key, value] :
       {std::pair{"exposure_s", r.exposure_s}, std::pair{"readout_s", r.readout_s}}) {
    if (value > interval_s(world)) {
      in.fail(key,
              fmt::format("is longer than the {:.4f} s between two images", interval_s(world)));
    }
  }
}

void read_timing(TableReader& in, World& world) {
  Timing& t = world.timing;
  t.jitter_s = in.number("jitter_s", t.jitter_s, 0.0, 1.0);
  t.right_offset_s = in.number("right_offset_s", t.right_offset_s, -1.0, 1.0);
  t.right_drift_ppm = in.number("right_drift_ppm", t.right_drift_ppm, -10000.0, 10000.0);
  t.drop_probability = in.number("drop_probability", t.drop_probability, 0.0, 0.9);
  t.late_probability = in.number("late_probability", t.late_probability, 0.0, 1.0);
  t.late_s = in.number("late_s", t.late_s, 0.0, 10.0);
  if (t.jitter_s > kMaxJitter * interval_s(world)) {
    in.fail("jitter_s", fmt::format("is more than {} of the {:.4f} s between two images",
                                    kMaxJitter, interval_s(world)));
  }
  if (std::abs(t.right_offset_s) > interval_s(world)) {
    in.fail("right_offset_s",
            fmt::format("is more than the {:.4f} s between two images", interval_s(world)));
  }
  if (t.late_probability > 0.0 && t.late_s <= 0.0) in.fail("late_probability", "needs late_s");
  if (t.late_s > 0.0 && t.late_probability <= 0.0) in.fail("late_s", "needs late_probability");
}

void read_calibration_error(TableReader& in, World& world) {
  CalibrationError& e = world.optics.error;
  e.right_yaw_rad = degrees(in, "right_yaw_deg", kMaxTilt_deg);
  e.right_pitch_rad = degrees(in, "right_pitch_deg", kMaxTilt_deg);
  e.right_roll_rad = degrees(in, "right_roll_deg", kMaxTilt_deg);
  e.right_focal_ratio = in.number("right_focal_ratio", e.right_focal_ratio, 0.5, 2.0);
  e.baseline_ratio = in.number("baseline_ratio", e.baseline_ratio, 0.5, 2.0);
}

}  // namespace egomod::sim
