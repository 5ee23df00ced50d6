// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/geometry.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod::synthetic {

inline const StereoCamera kCamera{525.0, 525.0, 320.0, 240.0, 0.375, 640, 480};

// A point that moves straight on in the first left camera's frame.
struct Point {
  Eigen::Vector3d at_start_m;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

// Tracks and egomotion of points seen by a moving rig, exact but for the noise asked for.
class World {
 public:
  double rate_hz = 30.0;
  Eigen::Vector3d rig_velocity_mps{0.0, 0.0, 0.4};
  double rig_yaw_rate_radps = 0.1;
  double pixel_sigma = 0.0;
  double disparity_sigma_px = 0.0;
  std::vector<Point> points;

  explicit World(unsigned seed = 1) : random_(seed) {}

  // A wall of points over the whole image, at different depths.
  void add_background(int count, double near_m = 3.0, double far_m = 12.0) {
    for (int k = 0; k < count; ++k) {
      const double z = between(near_m, far_m);
      points.push_back({{between(-0.55, 0.55) * z, between(-0.4, 0.4) * z, z}});
    }
  }
  void add_box(int count, const Eigen::Vector3d& centre_m, const Eigen::Vector3d& size_m,
               const Eigen::Vector3d& velocity_mps) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d offset{between(-0.5, 0.5), between(-0.5, 0.5), between(-0.5, 0.5)};
      points.push_back({centre_m + offset.cwiseProduct(size_m), velocity_mps});
    }
  }

  [[nodiscard]] double time_s(int pair) const { return pair / rate_hz; }
  [[nodiscard]] Nanoseconds exposure(int pair) const {
    return Nanoseconds(static_cast<std::int64_t>(1e9 * time_s(pair)));
  }
  [[nodiscard]] Eigen::Isometry3d T_first_camera(int pair) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = so3_exp({0.0, -rig_yaw_rate_radps * time_s(pair), 0.0});
    T.translation() = rig_velocity_mps * time_s(pair);
    return T;
  }
  [[nodiscard]] Eigen::Vector3d in_camera(std::size_t point, int pair) const {
    return T_first_camera(pair).inverse() *
           (points[point].at_start_m + time_s(pair) * points[point].velocity_mps);
  }
  [[nodiscard]] Eigen::Vector3d velocity_in_camera(std::size_t point, int pair) const {
    return T_first_camera(pair).linear().transpose() * points[point].velocity_mps;
  }

  // Pairs must be made in order; `step` is the distance to the previous one.
  [[nodiscard]] TrackSet tracks(int pair, int step = 1) {
    TrackSet set;
    set.sequence = static_cast<std::uint64_t>(pair);
    set.exposure = exposure(pair);
    set.previous_exposure = exposure(std::max(0, pair - step));
    set.status = pair == 0 ? TrackStatus::kFirst : TrackStatus::kOk;
    set.camera = kCamera;
    last_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      Track track;
      track.id = i + 1;
      track.age = static_cast<std::uint32_t>(pair);
      track.previous = last_[i].second;
      track.has_previous = last_[i].first && pair > 0;
      track.has_current = observe(in_camera(i, pair), track.current);
      last_[i] = {track.has_current, track.current};
      if (track.has_current || track.has_previous) set.tracks.push_back(track);
    }
    return set;
  }

  // Moving points are outliers, the others inliers: what a perfect RANSAC says.
  [[nodiscard]] Egomotion motion(const TrackSet& set, int pair, int step = 1) const {
    Egomotion motion;
    motion.sequence = set.sequence;
    motion.exposure = set.exposure;
    motion.previous_exposure = set.previous_exposure;
    motion.status = pair == 0 ? EstimateStatus::kFirst : EstimateStatus::kValid;
    motion.T_first_current = T_first_camera(0).inverse() * T_first_camera(pair);
    if (pair > 0) {
      motion.T_previous_current = T_first_camera(pair - step).inverse() * T_first_camera(pair);
    }
    for (const Track& track : set.tracks) {
      const bool moves = !points[track.id - 1].velocity_mps.isZero();
      motion.roles.push_back(moves ? TrackRole::kOutlier : TrackRole::kInlier);
    }
    return motion;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool observe(const Eigen::Vector3d& P_m, StereoObservation& observation) {
    std::normal_distribution<double> unit;
    const Eigen::Vector3d noise{pixel_sigma * unit(random_), pixel_sigma * unit(random_),
                                disparity_sigma_px * unit(random_)};
    if (P_m.z() < 0.5) return false;
    const Eigen::Vector3d m = project(kCamera, P_m) + noise;
    observation = {
        static_cast<float>(m.x()), static_cast<float>(m.y()), static_cast<float>(m.z()), {}};
    const auto uv = static_cast<float>(pixel_sigma * pixel_sigma);
    const auto dd = static_cast<float>(disparity_sigma_px * disparity_sigma_px);
    observation.covariance_px2 = {uv, 0.0F, 0.0F, uv, 0.0F, dd};
    return m.x() >= 0 && m.x() < kCamera.width_px && m.y() >= 0 && m.y() < kCamera.height_px &&
           m.z() > 0.5;
  }

  std::mt19937 random_;
  std::vector<std::pair<bool, StereoObservation>> last_;
};

}  // namespace egomod::synthetic
