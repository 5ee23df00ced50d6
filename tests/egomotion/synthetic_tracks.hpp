// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "egomod/core/geometry.hpp"
#include "egomod/core/track_set.hpp"

namespace egomod::synthetic {

inline const StereoCamera kCamera{525.0, 520.0, 320.6, 238.7, 0.375, 640, 480};

struct Noise {
  double u_px = 0.15;
  double v_px = 0.15;
  double disparity_px = 0.2;
};

inline Eigen::Vector3d gaussian3(std::mt19937& random) {
  std::normal_distribution<double> n;
  const double x = n(random);
  const double y = n(random);
  return {x, y, n(random)};
}

inline StereoObservation observe(const Eigen::Vector3d& P, const Noise& noise,
                                 std::mt19937& random) {
  const Eigen::Vector3d sigma{noise.u_px, noise.v_px, noise.disparity_px};
  const Eigen::Vector3d z = project(kCamera, P) + sigma.cwiseProduct(gaussian3(random));
  const Eigen::Vector3f f = z.cast<float>();
  const auto square = [](double x) { return static_cast<float>(x * x); };
  return {f.x(),
          f.y(),
          f.z(),
          {square(noise.u_px), 0, 0, square(noise.v_px), 0, square(noise.disparity_px)}};
}

// A point in the left camera frame, evenly over the image, 1.5 to 15 m away.
inline Eigen::Vector3d random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double u = unit(random) * kCamera.width_px;
  const double v = unit(random) * kCamera.height_px;
  const double z = 1.5 * std::pow(10.0, unit(random));
  return {(u - kCamera.cx_px) * z / kCamera.fx_px, (v - kCamera.cy_px) * z / kCamera.fy_px, z};
}

inline Vector6d random_motion(std::mt19937& random, double max_m, double max_rad) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vector6d xi;
  for (int k = 0; k < 6; ++k) xi[k] = unit(random) * (k < 3 ? max_m : max_rad);
  return xi;
}

inline bool visible(const Eigen::Vector3d& P) {
  if (P.z() < 0.7) return false;
  const Eigen::Vector3d z = project(kCamera, P);
  return z.x() >= 0 && z.y() >= 0 && z.x() < kCamera.width_px && z.y() < kCamera.height_px;
}

// The middle of the image shows one thing, at one depth, all around it is another.
struct Middle {
  double side = 0.5;  // of the image's width and height
  double depth_m = 1.6;
  double depth_around_m = 0.0;  // 0: as random points have it

  [[nodiscard]] bool holds(const Eigen::Vector3d& P) const {
    const Eigen::Vector3d z = project(kCamera, P);
    return std::abs(z.x() / kCamera.width_px - 0.5) < 0.5 * side &&
           std::abs(z.y() / kCamera.height_px - 0.5) < 0.5 * side;
  }
};

// A world of points that the rig moves through; the first `movers` of them move as one.
class World {
 public:
  // The mover fills the middle of the image, and hides what is behind it.
  World(std::uint32_t seed, std::size_t points, const Middle& middle)
      : random_(seed), mover_share_(0.0), mismatch_share_(0.0), middle_(middle) {
    tracks_.camera = kCamera;
    tracks_.status = TrackStatus::kFirst;
    for (std::size_t k = 0; k < points; ++k) seed_point(tracks_);
  }

  World(std::uint32_t seed, std::size_t points, double mover_share = 0.0,
        double mismatch_share = 0.0)
      : random_(seed), mover_share_(mover_share), mismatch_share_(mismatch_share) {
    tracks_.camera = kCamera;
    tracks_.status = TrackStatus::kFirst;
    for (std::size_t k = 0; k < points; ++k) seed_point(tracks_);
  }

  Noise noise;
  Eigen::Vector3d mover_velocity_m{0.15, 0.0, 0.05};  // a pair, first camera's axes

  // Moves the rig and observes; lost points are replaced, so the count stays.
  const TrackSet& step(const Eigen::Isometry3d& T_previous_current, double dt_s = 0.1) {
    T_first_current_ = orthonormalised(T_first_current_ * T_previous_current);
    tracks_.status = TrackStatus::kOk;
    tracks_.previous_exposure = tracks_.exposure;
    tracks_.exposure += Nanoseconds(static_cast<std::int64_t>(dt_s * 1e9));
    ++tracks_.sequence;
    std::size_t kept = 0;
    const std::size_t before = points_.size();
    for (std::size_t k = 0; k < before; ++k) kept += follow(k, kept) ? 1 : 0;
    points_.resize(kept);
    tracks_.tracks.resize(kept);
    while (points_.size() < before) seed_point(tracks_);
    return tracks_;
  }

  // That share of the tracks, spread evenly, is lost behind a mover and seen on it instead.
  void let_mover_in(double share) {
    mover_share_ = 1.0;
    const std::size_t before = points_.size();
    std::size_t kept = 0;
    for (std::size_t k = 0; k < before; ++k) {
      const auto lost = [&](std::size_t n) { return std::floor(share * static_cast<double>(n)); };
      if (lost(k + 1) > lost(k)) continue;
      points_[kept] = points_[k];
      tracks_.tracks[kept++] = tracks_.tracks[k];
    }
    points_.resize(kept);
    tracks_.tracks.resize(kept);
    while (points_.size() < before) seed_point(tracks_);
    mover_share_ = share;
  }

  // Other points take the place of all there were.
  void lose_all() {
    const std::size_t before = points_.size();
    points_.clear();
    tracks_.tracks.clear();
    while (points_.size() < before) seed_point(tracks_);
  }

  [[nodiscard]] const TrackSet& tracks() const { return tracks_; }
  TrackSet& tracks() { return tracks_; }
  [[nodiscard]] const Eigen::Isometry3d& T_first_current() const { return T_first_current_; }
  [[nodiscard]] bool is_mover(std::size_t track) const { return points_[track].mover; }

 private:
  struct Point {
    Eigen::Vector3d P_first;
    bool mover;
  };

  void seed_point(TrackSet& set) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    Eigen::Vector3d P = random_point(random_);
    bool mover = unit(random_) < mover_share_;
    if (middle_) {
      mover = middle_->holds(P);
      const double depth_m = mover ? middle_->depth_m : middle_->depth_around_m;
      if (depth_m > 0.0) P *= depth_m / P.z();
    }
    points_.push_back({T_first_current_ * P, mover});
    Track track;
    track.id = next_id_++;
    track.has_current = true;
    track.current = observe(P, noise, random_);
    set.tracks.push_back(track);
  }

  bool follow(std::size_t from, std::size_t to) {
    Point point = points_[from];
    Track track = tracks_.tracks[from];
    if (point.mover) point.P_first += mover_velocity_m;
    const Eigen::Vector3d P = T_first_current_.inverse() * point.P_first;
    if (!visible(P) || (middle_ && middle_->holds(P) != point.mover)) return false;
    ++track.age;
    track.previous = track.current;
    track.has_previous = true;
    track.current = observe(P, noise, random_);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    if (unit(random_) < mismatch_share_)
      track.current = observe(random_point(random_), noise, random_);
    points_[to] = point;
    tracks_.tracks[to] = track;
    return true;
  }

  std::mt19937 random_;
  double mover_share_;
  double mismatch_share_;
  std::optional<Middle> middle_;
  std::uint64_t next_id_ = 1;
  std::vector<Point> points_;
  TrackSet tracks_;
  Eigen::Isometry3d T_first_current_ = Eigen::Isometry3d::Identity();
};

}  // namespace egomod::synthetic
