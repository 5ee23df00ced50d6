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
constexpr double kMinShare = 0.1;
constexpr double kMaxSurprise = 100.0;  // beyond it nothing is told apart any more
// Of a motion that the wheels confirm, while they do not confirm the estimate.
constexpr std::size_t kMinTracksConfirmed = 10;
constexpr double kMinShareConfirmed = 0.03;
constexpr double kMinRatioConfirmed = 0.05;

double score(const Support& support) {
  return std::log1p(support.cells) + std::log1p(support.known_static) -
         0.5 * std::min(support.surprise, kMaxSurprise);
}

}  // namespace

bool RivalFinder::find(const TrackSet& tracks, const Solution& estimate,
                       std::span<const TrackRole> roles, std::span<const MapPoint> map,
                       double noise_scale, const VelocityPrior& prior, Rival& rival) {
  is_suspected_ = prior.wheels != nullptr && prior.wheels->surprise(estimate) > kSuspicion;
  const bool was_found = found_;
  found_ = search(tracks, estimate, roles, map, noise_scale, prior, rival);
  if (!found_ && was_found && lingers(tracks, map)) {
    rival = {.solution = last_, .preferred = false};
    rival.solution.T_previous_current =
        motion_of(velocity_of(last_.T_previous_current, last_dt_s_), prior.dt_s);
    found_ = true;
  }
  if (found_) {
    last_ = rival.solution;
    last_dt_s_ = prior.dt_s;
  }
  return found_;
}

// A motion that one pair does not tell from the estimate may be there all the same: as long as the
// map has had to give up the points of so much of the image, the last one found goes on.
bool RivalFinder::lingers(const TrackSet& tracks, std::span<const MapPoint> map) {
  clear_cells();
  for (std::size_t k = 0; k < map.size(); ++k) {
    if (!tracks.tracks[k].has_current || map[k].updates == 0) continue;
    Cell& cell = cell_of(tracks.camera, uvd(tracks.tracks[k].current));
    ++(is_given_up(map[k]) ? cell.rival : cell.estimate).tracks;
  }
  Support kept;
  Support given_up;
  count_support(kept, given_up);
  return given_up.cells >= config_.min_support_ratio * kept.cells;
}

RivalFinder::Least RivalFinder::least() const {
  const double ratio = found_ ? config_.ratio_to_stay : config_.min_support_ratio;
  if (!is_suspected_) return {kMinTracks, kMinShare, ratio};
  return {kMinTracksConfirmed, kMinShareConfirmed, std::min(ratio, kMinRatioConfirmed)};
}

bool RivalFinder::search(const TrackSet& tracks, const Solution& estimate,
                         std::span<const TrackRole> roles, std::span<const MapPoint> map,
                         double noise_scale, const VelocityPrior& prior, Rival& rival) {
  reserve(tracks.tracks.size());
  if (!enough_outliers(tracks, roles)) return false;
  gather(tracks, roles, noise_scale);
  if (unexplained_.size() < least().tracks) return false;
  rival.solution = is_suspected_ ? confirmed(tracks, estimate, *prior.wheels)
                                 : among_unexplained(tracks, estimate.T_previous_current);
  if (rival.solution.failure != EstimateReason::kNone) return false;
  vote(tracks, estimate.T_previous_current, rival.solution.T_previous_current, map);
  Support for_estimate;
  Support for_rival;
  count_support(for_estimate, for_rival);
  for_estimate.surprise = surprise(estimate, prior);
  for_rival.surprise = surprise(rival.solution, prior);
  if (is_suspected_ && for_rival.surprise > kSuspicion) is_suspected_ = false;  // not confirmed
  const auto [unused, share, ratio] = least();
  if (for_rival.cells < std::max(share * occupied_cells(), ratio * for_estimate.cells))
    return false;
  rival.preferred = prefers(for_rival, for_estimate, prior.wheels != nullptr);
  return true;
}

Solution RivalFinder::among_unexplained(const TrackSet& tracks, const Eigen::Isometry3d& start) {
  return solver_.solve(tracks.camera, unexplained_, start, tracks.sequence);
}

// Where the map knows little yet an estimate explains tracks of both motions: all are asked then.
Solution RivalFinder::confirmed(const TrackSet& tracks, const Solution& estimate,
                                const WheelsMotion& wheels) {
  Solution first = among_unexplained(tracks, wheels.T_previous_current);
  if (first.failure == EstimateReason::kNone && wheels.surprise(first) < kSuspicion) return first;
  Solution near = solver_.solve_near(tracks.camera, all_, wheels.T_previous_current);
  if (near.failure == EstimateReason::kNone && wheels.surprise(near) < kSuspicion) return near;
  return among_unexplained(tracks, estimate.T_previous_current);
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
  return outliers.cells >= kHidden * least().ratio * inliers.cells;
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
    if (!map.empty()) votes.knowledge += known_static(map[all_[k].track]);
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

double RivalFinder::surprise(const Solution& solution, const VelocityPrior& prior) const {
  if (prior.wheels != nullptr) return prior.wheels->surprise(solution);
  const Vector6d y = velocity_of(solution.T_previous_current, prior.dt_s);
  const Matrix6d to_velocity = motion_perturbation_of_velocity(y, prior.dt_s).inverse();
  const Matrix6d change = diagonal_covariance(config_.acceleration_sigma_mps2 * prior.dt_s,
                                              config_.turn_acceleration_sigma_radps2 * prior.dt_s);
  const Matrix6d S =
      prior.past.covariance + change + to_velocity * solution.covariance * to_velocity.transpose();
  const Vector6d innovation = y - prior.past.y;
  return innovation.dot(S.ldlt().solve(innovation));
}

// With wheels a mover may own all but little of the image.
bool RivalFinder::prefers(const Support& rival, const Support& estimate, bool has_wheels) const {
  if (!has_wheels && rival.cells > config_.overwhelming_ratio * estimate.cells) return true;
  return score(rival) > score(estimate);
}

}  // namespace egomod
