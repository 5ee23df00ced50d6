// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/track_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/correspondence.hpp"
#include "egomod/egomotion/robust_gauss_newton.hpp"
#include "egomod/egomotion/statistics.hpp"

namespace egomod {
namespace {

// It moved, or was lost: it must earn its weight anew, or movers leak in each time they start over.
constexpr double kWeightAfterReset = 0.02;
constexpr double kGivenUpBelow = 0.5;  // static weight
constexpr double kUpdatesToKnow = 15;

// What one pair sees of a point: innovation, its Jacobian in the point, its covariance.
struct Innovation {
  Eigen::Vector3d r;
  Eigen::Matrix3d H;
  Eigen::Matrix3d S;
  Eigen::Vector3d row_error_per_s = Eigen::Vector3d::Zero();  // of r
};

struct View {
  const StereoCamera& camera;
  Eigen::Isometry3d T_first_current;
  Eigen::Isometry3d T_current_first;
  const Matrix6d& pose_covariance;
  const RowTiming& rows;
  const Vector6d* motion_error_per_s;
};

Eigen::Matrix<double, 3, 6> pose_jacobian_in_space(const Eigen::Vector3d& P_current_m) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -skew(P_current_m);
  return J;
}

// Of a position in the current frame that is found from an observation.
Eigen::Vector3d row_error_in_space_per_s(const StereoCamera& camera, const Eigen::Vector3d& P_m,
                                         const Vector6d& velocity) {
  return triangulate_jacobian(camera, project(camera, P_m)) *
         row_displacement_per_s(camera, P_m, velocity);
}

// The observation as a position in the first frame, with the pose's uncertainty.
void locate(const View& view, const Eigen::Vector3d& z, const Eigen::Matrix3d& R,
            Eigen::Vector3d& P_first, Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d P = triangulate(view.camera, z);
  const Eigen::Matrix3d J = triangulate_jacobian(view.camera, z);
  const Eigen::Matrix<double, 3, 6> Jx = pose_jacobian_in_space(P);
  const Eigen::Matrix3d rotation = view.T_first_current.linear();
  P_first = view.T_first_current * P;
  covariance = rotation * (J * R * J.transpose() + Jx * view.pose_covariance * Jx.transpose()) *
               rotation.transpose();
}

// The first updates: (u, v, disparity) is too bent over a young track's uncertainty.
Innovation innovation_in_space(const View& view, const MapPoint& point, const Eigen::Vector3d& z,
                               const Eigen::Matrix3d& R) {
  Innovation i;
  Eigen::Vector3d P;
  locate(view, z, R, P, i.S);
  i.r = P - point.P_first_m;
  i.H.setIdentity();
  i.S += point.covariance_m2;
  if (view.motion_error_per_s == nullptr) return i;
  const Eigen::Vector3d P_current = triangulate(view.camera, z);
  i.row_error_per_s = view.T_first_current.linear() *
                          (row_error_in_space_per_s(view.camera, P_current, view.rows.velocity) +
                           pose_jacobian_in_space(P_current) * *view.motion_error_per_s) -
                      point.row_error_m_per_s;
  return i;
}

Innovation innovation_in_image(const View& view, const MapPoint& point, const Eigen::Vector3d& z,
                               const Eigen::Matrix3d& R) {
  Innovation i;
  Eigen::Vector3d P = view.T_current_first * point.P_first_m;
  P.z() = std::max(P.z(), kMinDepthM);
  const Eigen::Matrix<double, 3, 6> Jx = motion_jacobian(view.camera, P);
  i.r = z - project(view.camera, P);
  i.H = project_jacobian(view.camera, P) * view.T_current_first.linear();
  i.S =
      R + i.H * point.covariance_m2 * i.H.transpose() + Jx * view.pose_covariance * Jx.transpose();
  if (view.motion_error_per_s != nullptr)
    i.row_error_per_s = row_displacement_per_s(view.camera, P, view.rows.velocity) -
                        Jx * *view.motion_error_per_s - i.H * point.row_error_m_per_s;
  return i;
}

void fuse(const TrackMapConfig& config, const Innovation& i, bool is_told, bool is_held,
          MapPoint& point) {
  const Eigen::Matrix3d S_inverse = i.S.inverse();
  const double distance2 = i.r.dot(S_inverse * i.r);
  if (!std::isfinite(distance2)) return;
  if (!is_held) {
    const double cut = std::min(1.0, config.max_distance2 / std::max(distance2, 1e-12));
    const Eigen::Matrix3d K = cut * point.covariance_m2 * i.H.transpose() * S_inverse;
    point.P_first_m += K * i.r;
    point.row_error_m_per_s += K * i.row_error_per_s;
    const Eigen::Matrix3d C = point.covariance_m2 - K * i.H * point.covariance_m2;
    point.covariance_m2 = 0.5 * (C + C.transpose());
    ++point.updates;
  } else {
    ++point.held;
  }
  const bool fits = distance2 < kChi2Of3At99Percent;
  const double rate = fits ? config.trust_rate : config.distrust_rate;
  point.static_weight += rate * ((fits ? 1.0 : 0.0) - point.static_weight);
  if (is_told) point.stood = std::max(0, point.stood + (fits ? 1 : -1));
}

}  // namespace

double known_static(const MapPoint& point) {
  return point.static_weight * std::min(1.0, (point.updates - point.doubted) / kUpdatesToKnow);
}

bool is_given_up(const MapPoint& point) { return point.static_weight < kGivenUpBelow; }

void TrackMap::align(std::span<const Track> tracks, double dt_s) {
  const double fade = std::pow(config_.fade_per_s, dt_s);
  next_.clear();
  auto old = points_.begin();
  for (const Track& track : tracks) {
    while (old != points_.end() && old->track_id < track.id) ++old;
    MapPoint& point = next_.emplace_back();
    if (old != points_.end() && old->track_id == track.id) point = *old;
    point.track_id = track.id;
    point.covariance_m2 *= fade;
  }
  points_.swap(next_);
}

void TrackMap::update(const StereoCamera& camera, std::span<const Track> tracks,
                      const Eigen::Isometry3d& T_first_current, const Matrix6d& pose_covariance,
                      double noise_scale, bool is_doubted, bool is_told, bool is_held,
                      const RowTiming& rows, const Vector6d* motion_error_per_s) {
  const View view{camera, T_first_current,   T_first_current.inverse(), pose_covariance,
                  rows,   motion_error_per_s};
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    const Track& track = tracks[k];
    MapPoint& point = points_[k];
    if (!track.has_current || !usable(track.current)) continue;
    const Eigen::Vector3d z = at_middle_row(camera, uvd(track.current), rows);
    const Eigen::Matrix3d R = noise_scale * covariance(track.current);
    if (point.updates > 0 && point.static_weight < config_.reset_below_weight) {
      point.updates = 0;
      point.doubted = 0;
      point.earlier = 0;
      point.held = 0;
      point.static_weight = kWeightAfterReset;
    }
    if (point.updates == 0) {
      locate(view, z, R, point.P_first_m, point.covariance_m2);
      point.row_error_m_per_s =
          T_first_current.linear() *
          row_error_in_space_per_s(camera, triangulate(camera, z), rows.velocity);
      point.updates = 1;
      continue;
    }
    point.doubted += is_doubted && !is_held ? 1 : 0;
    const bool young = point.updates <= config_.linear_updates;
    fuse(config_,
         young ? innovation_in_space(view, point, z, R) : innovation_in_image(view, point, z, R),
         is_told, is_held, point);
    if (motion_error_per_s != nullptr)
      point.row_error_m_per_s -=
          T_first_current.linear() *
          (pose_jacobian_in_space(view.T_current_first * point.P_first_m) * *motion_error_per_s);
  }
}

void TrackMap::begin_again(std::span<const double> shares) {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    MapPoint& point = points_[k];
    const bool belongs = shares[k] > kGivenUpBelow;
    point.earlier = belongs ? point.earlier + point.updates + point.held : 0;
    point.held = 0;
    if (!belongs) point.stood = 0;
    point.updates = 0;
    point.doubted = 0;
    point.static_weight = std::max(kWeightAfterReset, shares[k]);
  }
}

void TrackMap::note_first_velocity(const StereoCamera& camera,
                                   const Eigen::Isometry3d& T_first_previous,
                                   const Vector6d& velocity) {
  const Eigen::Isometry3d T = T_first_previous.inverse();
  for (MapPoint& point : points_)
    if (point.updates == 1)
      point.row_error_m_per_s = T_first_previous.linear() *
                                row_error_in_space_per_s(camera, T * point.P_first_m, velocity);
}

void TrackMap::change_readout(double change_s) {
  if (change_s == 0.0) return;
  for (MapPoint& point : points_) point.P_first_m -= change_s * point.row_error_m_per_s;
}

}  // namespace egomod
