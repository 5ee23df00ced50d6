// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "egomod/core/frame.hpp"
#include "egomod/core/geometry.hpp"

namespace egomod::test {

inline Matrix6d some_covariance() {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = 0.01 * ((i * 7) % 11 - 5);
  return A * A.transpose() + 1e-4 * Matrix6d::Identity();
}

inline Eigen::Isometry3d some_T_body_camera() {
  Eigen::Isometry3d T = default_T_body_camera();
  T.translation() = Eigen::Vector3d(0.2, -0.1, 0.5);
  T.linear() = so3_exp({0.05, 0.3, -0.1}) * T.linear();
  return T;
}

inline MovingObject some_object(std::int64_t id) {
  MovingObject object;
  object.id = id;
  object.state = ObjectState::kMoving;
  object.age_s = 1.5;
  object.position_m = {1.0, -0.5, 6.0};
  object.position_covariance_m2 = Eigen::Vector3d(0.01, 0.02, 0.09).asDiagonal();
  object.velocity_mps = {0.4, 0.0, -0.3};
  object.velocity_covariance_m2ps2 = Eigen::Vector3d(0.001, 0.002, 0.004).asDiagonal();
  object.rectangle = {.u_min_px = 10.5F, .v_min_px = 20.0F, .u_max_px = 99.0F, .v_max_px = 80.25F};
  object.extent_m = {0.5, 1.7, 0.3};
  object.points = 12;
  object.speed_mps = 0.5;
  object.speed_sigma_mps = 0.02;
  object.motion_probability = 0.99;
  return object;
}

// The pair `sequence` of a rig that moves 0.1 m forward and turns a little each 0.1 s.
inline Frame some_frame(std::uint64_t sequence) {
  const Vector6d step{0.002, -0.001, 0.1, 0.001, 0.02, -0.003};
  Frame frame;
  frame.pair.sequence = sequence;
  frame.pair.exposure = sequence * std::chrono::milliseconds(100);
  frame.pair.right_exposure = frame.pair.exposure + std::chrono::milliseconds(2);
  frame.pair.calibration.camera = {.fx_px = 525,
                                   .fy_px = 525,
                                   .cx_px = 31.5,
                                   .cy_px = 23.5,
                                   .baseline_m = 0.375,
                                   .width_px = 64,
                                   .height_px = 48};
  frame.pair.calibration.T_body_camera = some_T_body_camera();
  for (Image* image : {&frame.pair.left, &frame.pair.right}) {
    image->resize(64, 48);
    for (int v = 0; v < 48; ++v) {
      for (int u = 0; u < 64; ++u) image->row(v)[u] = static_cast<std::uint8_t>(3 * u + v);
    }
  }
  Egomotion& motion = frame.motion;
  motion.sequence = sequence;
  motion.exposure = frame.pair.exposure;
  motion.status = sequence == 0 ? EstimateStatus::kFirst : EstimateStatus::kValid;
  motion.quality = 80;
  motion.inliers = 200;
  if (sequence > 0) {
    motion.previous_exposure = motion.exposure - std::chrono::milliseconds(100);
    motion.T_previous_current = se3_exp(step);
    motion.covariance_previous_current = some_covariance();
    motion.covariance_first_current = static_cast<double>(sequence) * some_covariance();
    motion.T_first_current = se3_exp(step * static_cast<double>(sequence));
  }
  frame.objects.has_run = true;
  frame.objects.objects = {some_object(7)};
  frame.tracks.tracks.resize(2);
  frame.tracks.tracks[0].id = 3;
  frame.tracks.tracks[0].has_current = true;
  frame.tracks.tracks[1].id = 4;
  frame.tracks.tracks[1].has_current = true;
  motion.roles = {TrackRole::kInlier, TrackRole::kOutlier};
  frame.objects.points = {{.track_id = 4,
                           .state = PointState::kMoving,
                           .object_id = 7,
                           .evidence = 9.5F,
                           .chi2 = 40.25F}};
  return frame;
}

// An empty folder that goes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = std::filesystem::temp_directory_path() / "egomod-publish-XXXXXX";
    path_ = ::mkdtemp(name.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string contents_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Event {
  std::string channel;
  std::int64_t utime_us = 0;
  std::string bytes;
};

inline std::vector<Event> events_of(const std::string& path) {
  std::vector<Event> events;
  lcm::LogFile log(path, "r");
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    events.push_back({event->channel, event->timestamp,
                      std::string(static_cast<const char*>(event->data),
                                  static_cast<std::size_t>(event->datalen))});
  }
  return events;
}

}  // namespace egomod::test
