// SPDX-License-Identifier: Apache-2.0
// Which motion the cells of the image vote for, and how much room a motion's cells take.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/rival_finder.hpp"
#include "egomod/egomotion/statistics.hpp"

namespace egomod {
namespace {

// A point that both motions explain in this pair belongs to the one that it has followed, once the
// two would have displaced it by so much.
constexpr double kDisplacedPx = 3.0;
constexpr int kMostPairsDisplaced = 30;
// Standard deviations of a thing that is flat, in widths and heights of the image and in depth.
constexpr double kFlatPlace = 0.05;
constexpr double kFlatLogDepth = 0.1;
constexpr int kTrims = 3;
constexpr double kTrimmedDistance2 = 8.0;
constexpr double kShareUnknown = 0.5;

}  // namespace

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

RivalFinder::Side RivalFinder::side_of(std::size_t index, const StereoCamera& camera,
                                       const Eigen::Isometry3d& T_estimate_previous,
                                       const Eigen::Isometry3d& T_rival_previous,
                                       const MapPoint* point) const {
  const bool fits_estimate = by_estimate_[index] < kChi2Of3At99Percent;
  const bool fits_rival = by_rival_[index] < kChi2Of3At99Percent;
  if (fits_estimate != fits_rival) return fits_estimate ? Side::kEstimate : Side::kRival;
  if (!fits_estimate || point == nullptr) return Side::kNone;
  if (is_given_up(*point)) return Side::kRival;
  const Eigen::Vector3d& P = all_[index].P_previous_m;
  const Eigen::Vector2d apart_px =
      (project(camera, T_estimate_previous * P) - project(camera, T_rival_previous * P)).head<2>();
  const int pairs = std::min(point->updates + point->earlier, kMostPairsDisplaced);
  return pairs * apart_px.norm() > kDisplacedPx ? Side::kEstimate : Side::kNone;
}

void RivalFinder::vote(const TrackSet& tracks, const Eigen::Isometry3d& T_estimate,
                       const Eigen::Isometry3d& T_rival, std::span<const MapPoint> map) {
  clear_cells();
  whitened_.measure_distances2(T_rival.inverse(), by_rival_);
  for (std::size_t k = 0; k < all_.size(); ++k) {
    Cell& cell = cell_of(tracks.camera, all_[k].observed_px);
    ++cell.tracks;
    const MapPoint* point = map.empty() ? nullptr : &map[all_[k].track];
    const Side side = side_of(k, tracks.camera, T_estimate.inverse(), T_rival.inverse(), point);
    if (side == Side::kNone) continue;
    Votes& votes = side == Side::kEstimate ? cell.estimate : cell.rival;
    ++votes.tracks;
    votes.log_depth += std::log(all_[k].P_previous_m.z());
    if (point == nullptr) continue;
    votes.knowledge += known_static(*point);
    votes.stood += point->stood;
  }
}

void RivalFinder::count_support(Support& estimate, Support& rival) const {
  for (const Cell& cell : cells_) {
    const int all = cell.estimate.tracks + cell.rival.tracks;
    if (all == 0) continue;
    estimate.cells += static_cast<double>(cell.estimate.tracks) / all;
    rival.cells += static_cast<double>(cell.rival.tracks) / all;
    estimate.stood += static_cast<double>(cell.estimate.stood) / all;
    rival.stood += static_cast<double>(cell.rival.stood) / all;
    estimate.known_static += cell.estimate.knowledge / all;
    rival.known_static += cell.rival.knowledge / all;
  }
}

// The logarithm of the volume over which a motion's cells scatter, by place in the image and
// logarithm of depth, without those that lie far off.
double RivalFinder::log_room(bool of_rival) const {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (int trim = 0; trim < kTrims; ++trim) {
    double n = 0.0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (int k = 0; k < kColumns * kRows; ++k) {
      const Cell& cell = cells_[static_cast<std::size_t>(k)];
      const Votes& own = of_rival ? cell.rival : cell.estimate;
      if (own.tracks == 0) continue;
      const Eigen::Vector3d x{static_cast<double>(k % kColumns) / kColumns,
                              static_cast<double>(k / kColumns) / kRows,
                              own.log_depth / own.tracks};
      if ((x - mean).dot(information * (x - mean)) > kTrimmedDistance2) continue;
      const double w = own.tracks / static_cast<double>(cell.estimate.tracks + cell.rival.tracks);
      n += w;
      sum += w * x;
      squares += w * x * x.transpose();
    }
    if (n == 0.0) break;
    mean = sum / n;
    Eigen::Matrix3d C = squares / n - mean * mean.transpose();
    C.diagonal() += Eigen::Vector3d(kFlatPlace, kFlatPlace, kFlatLogDepth).cwiseAbs2();
    information = C.inverse();
  }
  return -0.5 * std::log(information.determinant());
}

// How surely each track belongs to the rival: by the pair, else by its cell.
void RivalFinder::share_out(const TrackSet& tracks, Rival& rival) {
  rival.shares.assign(tracks.tracks.size(), kShareUnknown);
  for (std::size_t k = 0; k < tracks.tracks.size(); ++k) {
    if (!tracks.tracks[k].has_current) continue;
    const Cell& cell = cell_of(tracks.camera, uvd(tracks.tracks[k].current));
    const int all = cell.estimate.tracks + cell.rival.tracks;
    if (all > 0) rival.shares[k] = static_cast<double>(cell.rival.tracks) / all;
  }
  for (std::size_t k = 0; k < all_.size(); ++k) {
    const bool fits_estimate = by_estimate_[k] < kChi2Of3At99Percent;
    const bool fits_rival = by_rival_[k] < kChi2Of3At99Percent;
    double& share = rival.shares[all_[k].track];
    if (!fits_rival)
      share = 0.0;
    else if (!fits_estimate)
      share = 1.0;
  }
}

}  // namespace egomod
