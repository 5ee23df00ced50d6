// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/rival_finder.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/statistics.hpp"
#include "residual_kernels.hpp"

namespace egomod {
namespace {

constexpr double kHidden = 0.5;  // at most this share of a mover's tracks passes for static
constexpr std::size_t kMinTracks = 20;
constexpr double kMinShare = 0.1;       // of all cells, that tell the two motions apart
constexpr double kUpdatesToKnow = 15;   // of a track in the map
constexpr double kMaxSurprise = 100.0;  // beyond it nothing is told apart any more

double knowledge(const MapPoint& point) {
  return point.static_weight * std::min(1.0, point.updates / kUpdatesToKnow);
}

double score(const Support& support) {
  return std::log1p(support.cells) + std::log1p(support.known_static) -
         0.5 * std::min(support.surprise, kMaxSurprise);
}

}  // namespace

bool RivalFinder::find(const TrackSet& tracks, const Solution& estimate,
                       std::span<const TrackRole> roles, std::span<const MapPoint> map,
                       double noise_scale, const VelocityState& velocity, double dt_s,
                       Rival& rival) {
  found_ = search(tracks, estimate, roles, map, noise_scale, velocity, dt_s, rival);
  return found_;
}

bool RivalFinder::search(const TrackSet& tracks, const Solution& estimate,
                         std::span<const TrackRole> roles, std::span<const MapPoint> map,
                         double noise_scale, const VelocityState& velocity, double dt_s,
                         Rival& rival) {
  reserve(tracks.tracks.size());
  if (!enough_outliers(tracks, roles)) return false;
  gather(tracks, roles, noise_scale);
  if (unexplained_.size() < kMinTracks) return false;
  rival.solution =
      solver_.solve(tracks.camera, unexplained_, estimate.T_previous_current, tracks.sequence);
  if (rival.solution.failure != EstimateReason::kNone) return false;
  vote(tracks, estimate.T_previous_current, rival.solution.T_previous_current, map);
  Support for_estimate;
  Support for_rival;
  count_support(for_estimate, for_rival);
  const double least = std::max(kMinShare * occupied_cells(), least_ratio() * for_estimate.cells);
  if (for_rival.cells < least) return false;
  for_estimate.surprise = surprise(estimate, velocity, dt_s);
  for_rival.surprise = surprise(rival.solution, velocity, dt_s);
  rival.preferred = prefers(for_rival, for_estimate);
  return true;
}

// Before movers come, so that their coming allocates nothing.
void RivalFinder::reserve(std::size_t points) {
  solver_.reserve(points);
  whitened_.reserve(points);
  all_.reserve(points);
  unexplained_.reserve(points);
  by_estimate_.reserve(points + kResidualLanes);
  by_rival_.reserve(points + kResidualLanes);
}

RivalFinder::Cell& RivalFinder::cell_of(const StereoCamera& camera,
                                        const Eigen::Vector3d& observed_px) {
  const auto place = [](double x_px, int size_px, int count) {
    return std::clamp(static_cast<int>(count * x_px / std::max(1, size_px)), 0, count - 1);
  };
  const int column = place(observed_px.x(), camera.width_px, kColumns);
  const int row = place(observed_px.y(), camera.height_px, kRows);
  return cells_[static_cast<std::size_t>(row * kColumns + column)];
}

double RivalFinder::occupied_cells() const {
  return static_cast<double>(
      std::count_if(cells_.begin(), cells_.end(), [](const Cell& c) { return c.tracks > 0; }));
}

bool RivalFinder::enough_outliers(const TrackSet& tracks, std::span<const TrackRole> roles) {
  clear_cells();
  for (std::size_t k = 0; k < roles.size(); ++k) {
    if (roles[k] == TrackRole::kUnused) continue;
    Cell& cell = cell_of(tracks.camera, uvd(tracks.tracks[k].current));
    ++(roles[k] == TrackRole::kInlier ? cell.estimate : cell.rival).tracks;
  }
  Support inliers;
  Support outliers;
  count_support(inliers, outliers);
  return outliers.cells >= kHidden * least_ratio() * inliers.cells;
}

void RivalFinder::gather(const TrackSet& tracks, std::span<const TrackRole> roles,
                         double noise_scale) {
  all_.clear();
  unexplained_.clear();
  for (std::size_t k = 0; k < tracks.tracks.size(); ++k) {
    const Track& track = tracks.tracks[k];
    Correspondence c;
    if (roles[k] == TrackRole::kUnused || !usable(track.previous) ||
        !correspondence_of(tracks.camera, uvd(track.previous),
                           noise_scale * covariance(track.previous), c))
      continue;
    c.track = k;
    c.observed_px = uvd(track.current);
    c.covariance_observed_px2 = noise_scale * covariance(track.current);
    all_.push_back(c);
    if (roles[k] == TrackRole::kOutlier) unexplained_.push_back(c);
  }
}

void RivalFinder::vote(const TrackSet& tracks, const Eigen::Isometry3d& T_estimate,
                       const Eigen::Isometry3d& T_rival, std::span<const MapPoint> map) {
  clear_cells();
  whitened_.prepare(tracks.camera, all_, T_estimate);
  whitened_.measure_distances2(T_estimate.inverse(), by_estimate_);
  whitened_.measure_distances2(T_rival.inverse(), by_rival_);
  for (std::size_t k = 0; k < all_.size(); ++k) {
    Cell& cell = cell_of(tracks.camera, all_[k].observed_px);
    ++cell.tracks;
    const bool fits_estimate = by_estimate_[k] < kChi2Of3At99Percent;
    const bool fits_rival = by_rival_[k] < kChi2Of3At99Percent;
    if (fits_estimate == fits_rival) continue;
    Votes& votes = fits_estimate ? cell.estimate : cell.rival;
    ++votes.tracks;
    if (!map.empty()) votes.knowledge += knowledge(map[all_[k].track]);
  }
}

void RivalFinder::count_support(Support& estimate, Support& rival) const {
  for (const Cell& cell : cells_) {
    const int all = cell.estimate.tracks + cell.rival.tracks;
    if (all == 0) continue;
    estimate.cells += static_cast<double>(cell.estimate.tracks) / all;
    rival.cells += static_cast<double>(cell.rival.tracks) / all;
    estimate.known_static += cell.estimate.knowledge / all;
    rival.known_static += cell.rival.knowledge / all;
  }
}

double RivalFinder::surprise(const Solution& solution, const VelocityState& velocity,
                             double dt_s) const {
  const Vector6d y = velocity_of(solution.T_previous_current, dt_s);
  const Matrix6d to_velocity = motion_perturbation_of_velocity(y, dt_s).inverse();
  const Matrix6d change = diagonal_covariance(config_.acceleration_sigma_mps2 * dt_s,
                                              config_.turn_acceleration_sigma_radps2 * dt_s);
  const Matrix6d S =
      velocity.covariance + change + to_velocity * solution.covariance * to_velocity.transpose();
  const Vector6d innovation = y - velocity.y;
  return innovation.dot(S.ldlt().solve(innovation));
}

bool RivalFinder::prefers(const Support& rival, const Support& estimate) const {
  if (rival.cells > config_.overwhelming_ratio * estimate.cells) return true;
  return score(rival) > score(estimate);
}

}  // namespace egomod
