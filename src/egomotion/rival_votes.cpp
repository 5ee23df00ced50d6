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

// Once the two motions would have displaced a point by so much, it tells which of them it follows.
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

// A point that both motions explain in this pair belongs to the one that it has followed so far.
RivalFinder::Side RivalFinder::followed(const MapPoint& point, const Eigen::Vector2d& apart_px) {
  if (is_given_up(point)) return Side::kRival;
  const int pairs = std::min(point.updates + point.earlier + point.held, kMostPairsDisplaced);
  return pairs * apart_px.norm() > kDisplacedPx ? Side::kEstimate : Side::kNone;
}

void RivalFinder::vote(const TrackSet& tracks, const Eigen::Isometry3d& T_estimate,
                       const Eigen::Isometry3d& T_rival, std::span<const MapPoint> map) {
  clear_cells();
  whitened_.measure_distances2(T_rival.inverse(), by_rival_);
  const auto place_px = [&](const Eigen::Isometry3d& T, std::size_t k) -> Eigen::Vector2d {
    return project(tracks.camera, T.inverse() * all_[k].P_previous_m).head<2>();
  };
  for (std::size_t k = 0; k < all_.size(); ++k) {
    Cell& cell = cell_of(tracks.camera, all_[k].observed_px);
    ++cell.tracks;
    const bool fits_estimate = by_estimate_[k] < kChi2Of3At99Percent;
    const bool fits_rival = by_rival_[k] < kChi2Of3At99Percent;
    if (!fits_estimate && !fits_rival) continue;
    const MapPoint* point = map.empty() ? nullptr : &map[all_[k].track];
    Side side = fits_estimate ? Side::kEstimate : Side::kRival;
    if (fits_estimate && fits_rival)
      side = point == nullptr ? Side::kNone
                              : followed(*point, place_px(T_estimate, k) - place_px(T_rival, k));
    if (side == Side::kNone) continue;
    Votes& votes = side == Side::kEstimate ? cell.estimate : cell.rival;
    ++votes.with_followed;
    votes.log_depth += std::log(all_[k].P_previous_m.z());
    if (point != nullptr) votes.stood += point->stood;
    if (fits_estimate == fits_rival) continue;
    ++votes.tracks;
    if (point != nullptr) votes.knowledge += known_static(*point);
  }
}

void RivalFinder::count_support(Support& estimate, Support& rival) const {
  for (const Cell& cell : cells_) {
    const int with_followed = cell.estimate.with_followed + cell.rival.with_followed;
    if (with_followed > 0) {
      estimate.cells_with_followed +=
          static_cast<double>(cell.estimate.with_followed) / with_followed;
      rival.cells_with_followed += static_cast<double>(cell.rival.with_followed) / with_followed;
      estimate.stood += static_cast<double>(cell.estimate.stood) / with_followed;
      rival.stood += static_cast<double>(cell.rival.stood) / with_followed;
    }
    const int all = cell.estimate.tracks + cell.rival.tracks;
    if (all == 0) continue;
    estimate.cells += static_cast<double>(cell.estimate.tracks) / all;
    rival.cells += static_cast<double>(cell.rival.tracks) / all;
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
      if (own.with_followed == 0) continue;
      const int row = k / kColumns;
      const Eigen::Vector3d x{static_cast<double>(k % kColumns) / kColumns,
                              static_cast<double>(row) / kRows, own.log_depth / own.with_followed};
      if ((x - mean).dot(information * (x - mean)) > kTrimmedDistance2) continue;
      const double w = own.with_followed /
                       static_cast<double>(cell.estimate.with_followed + cell.rival.with_followed);
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
    const int all = cell.estimate.with_followed + cell.rival.with_followed;
    if (all > 0) rival.shares[k] = static_cast<double>(cell.rival.with_followed) / all;
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
