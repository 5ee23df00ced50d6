// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/rival_finder.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "egomod/core/geometry.hpp"
#include "egomod/egomotion/statistics.hpp"
#include "residual_kernels.hpp"

namespace egomod {
namespace {

constexpr double kHidden = 0.5;  // at most this share of a mover's tracks passes for static
constexpr std::size_t kMinTracks = 20;
constexpr double kMinShare = 0.1;
// Squared distance from the estimate. The map may be off for a track that moves along with it.
constexpr double kUnexplained2 = 3.0;
constexpr double kMaxSurprise = 100.0;  // beyond it nothing is told apart any more
// The same of a habit, which ends in doubt, since it is one of the two motions' then.
constexpr double kMaxSurpriseOfHabit = 20.0;
constexpr double kHabitLostS = 0.5;
// Of a motion that the wheels confirm, while they do not confirm the estimate.
constexpr std::size_t kMinTracksConfirmed = 10;
constexpr double kMinShareConfirmed = 0.03;
constexpr double kMinRatioConfirmed = 0.05;
// Logarithms of how much more room the rival takes than the estimate. So much is chance, each more
// speaks for it by that much.
constexpr double kRoomByChance = 0.4;
constexpr double kPerRoom = 16.0;
constexpr double kMaxRoom = 2.0;
constexpr double kRoomS = 0.3;             // over which it is averaged
constexpr double kPairsWithoutRoom = 2.0;  // that the mean begins with
constexpr double kForgottenRoom = 0.1;
constexpr double kCellsWithRoom = 5.0;
// A motion that takes more room counts with less of the image: from there on, how fast, at least.
constexpr double kRoomToCount = 0.15;
constexpr double kCountPerRoom = 3.0;
constexpr double kLeastByRoom = 0.3;
// How much longer the points of one have stood still than twice those of the other.
constexpr double kPerStoodS = 8.0;
constexpr double kMostStoodS = 3.0;
constexpr double kStoodFadesS = 4.0;
constexpr double kSurelyAcross = 0.5;
// Apart by so much in a pair, a motion is seen if it is there: half a pixel at 20 m, more nearer.
constexpr double kToldByOnePairM = 0.02;
// Few of all tracks tell another motion and are all around: they scatter over this share of what
// all do, where a mover has its share of the image.
constexpr double kFewToTell = 0.15;
constexpr double kAllAround = 0.6;
constexpr double kLeastKept = 0.6;  // of its cells; less, and it has become the estimate
constexpr double kLeverM = 3.0;     // of turns, where velocities are compared

double score(const Support& support) {
  return std::log1p(support.cells) + std::log1p(support.known_static) - 0.5 * support.surprise;
}

double beyond_chance(double room) { return room - std::clamp(room, -kRoomByChance, kRoomByChance); }

// Over which points scatter in the image.
double area_px2(std::span<const Correspondence> points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (const Correspondence& c : points) {
    const Eigen::Vector2d x = c.observed_px.head<2>();
    sum += x;
    squares += x * x.transpose();
  }
  const auto n = static_cast<double>(points.size());
  return std::sqrt(std::max(0.0, (squares / n - sum * sum.transpose() / (n * n)).determinant()));
}

double velocity_distance(const Vector6d& a, const Vector6d& b) {
  return (a - b).head<3>().norm() + kLeverM * (a - b).tail<3>().norm();
}

}  // namespace

bool RivalFinder::goes_on(const Solution& estimate, double dt_s, Solution& other) const {
  if (!found_) return false;
  other = estimate;
  other.T_previous_current = motion_of(past_.other, dt_s);
  return true;
}

bool RivalFinder::find(const TrackSet& tracks, const Solution& estimate,
                       std::span<const TrackRole> roles, std::span<const MapPoint> map,
                       double noise_scale, const VelocityPrior& prior, Rival& rival) {
  is_suspected_ = prior.wheels != nullptr && prior.wheels->surprise(estimate) > kSuspicion;
  const bool was_found = found_;
  rival.preferred = rival.against_map = false;
  is_measured_ = false;
  found_ = search(tracks, estimate, roles, map, noise_scale, prior, rival);
  if (!found_ && was_found && !shows_in_one_pair(estimate, prior.dt_s) && lingers(tracks, map)) {
    rival.solution = last_;
    rival.solution.T_previous_current = motion_of(past_.other, prior.dt_s);
    found_ = true;
  }
  past_.doubt_s = std::max(0.0, past_.doubt_s + (found_ ? prior.dt_s : -prior.dt_s));
  const Solution& chosen = rival.preferred ? rival.solution : estimate;
  past_.chosen = velocity_of(chosen.T_previous_current, prior.dt_s);
  if (is_measured_) {
    last_ = rival.preferred ? estimate : rival.solution;
    past_.other = velocity_of(last_.T_previous_current, prior.dt_s);
  } else if (!found_) {
    forget(prior.dt_s);
  }
  return found_;
}

void RivalFinder::forget(double dt_s) {
  const double kept = std::exp(-dt_s / kRoomS);
  past_.room *= kept;
  past_.stood_s *= kept;
  if (std::abs(past_.room) < kForgottenRoom) past_.pairs = 0;
}

bool RivalFinder::shows_in_one_pair(const Solution& estimate, double dt_s) const {
  const Vector6d velocity = velocity_of(estimate.T_previous_current, dt_s);
  return velocity_distance(past_.other, velocity) * dt_s > kToldByOnePairM;
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
  rival.shares.reserve(tracks.tracks.size());
  if (!enough_outliers(tracks, roles)) return false;
  gather(tracks, roles, noise_scale, estimate);
  if (unexplained_.size() < least().tracks) return false;
  const Eigen::Isometry3d start =
      found_ ? motion_of(past_.other, prior.dt_s) : estimate.T_previous_current;
  rival.solution =
      is_suspected_ ? confirmed(tracks, estimate, *prior.wheels) : among_unexplained(tracks, start);
  if (rival.solution.failure != EstimateReason::kNone) return false;
  if (!found_ && !is_suspected_) refine(tracks, roles, estimate, rival.solution);
  vote(tracks, estimate.T_previous_current, rival.solution.T_previous_current, map);
  Support for_estimate;
  Support for_rival;
  count_support(for_estimate, for_rival);
  for_estimate.surprise = surprise(estimate, prior);
  for_rival.surprise = surprise(rival.solution, prior);
  if (is_suspected_ && for_rival.surprise > kSuspicion) is_suspected_ = false;  // not confirmed
  weigh_past(estimate, rival.solution, prior.dt_s, for_estimate, for_rival);
  const auto [unused, share, ratio] = least();
  const double by_room =
      std::clamp(std::exp(kCountPerRoom * (kRoomToCount - past_.room)), kLeastByRoom, 1.0);
  if (for_rival.cells < std::max(share * occupied_cells(), by_room * ratio * for_estimate.cells))
    return false;
  rival.preferred = prefers(for_rival, for_estimate, prior.wheels != nullptr);
  if (rival.preferred) swap(tracks, for_estimate, for_rival, rival);
  return true;
}

// What has been seen of the two so far; which of them is which of the last pair's, velocity tells.
void RivalFinder::weigh_past(const Solution& estimate, const Solution& rival, double dt_s,
                             const Support& for_estimate, const Support& for_rival) {
  const Vector6d e = velocity_of(estimate.T_previous_current, dt_s);
  const Vector6d r = velocity_of(rival.T_previous_current, dt_s);
  const double straight = velocity_distance(e, past_.chosen) + velocity_distance(r, past_.other);
  const double across = velocity_distance(e, past_.other) + velocity_distance(r, past_.chosen);
  const bool crossed = past_.pairs > 0 && across < kSurelyAcross * straight;
  if (crossed) past_.turn_round();
  is_measured_ = true;
  ++past_.pairs;
  const double rate =
      std::max(1.0 - std::exp(-dt_s / kRoomS), 1.0 / (past_.pairs + kPairsWithoutRoom));
  const bool tells =
      std::min(for_estimate.cells_with_followed, for_rival.cells_with_followed) >= kCellsWithRoom;
  const double room = tells ? std::clamp(log_room(true) - log_room(false), -kMaxRoom, kMaxRoom) : 0;
  past_.room += rate * (room - past_.room);
  const auto stood_s = [dt_s](const Support& support) {
    return std::min(kMostStoodS, dt_s * support.stood / std::max(1.0, support.cells_with_followed));
  };
  const double longer_s = std::max(0.0, stood_s(for_rival) - 2.0 * stood_s(for_estimate)) -
                          std::max(0.0, stood_s(for_estimate) - 2.0 * stood_s(for_rival));
  past_.stood_s *= std::exp(-dt_s / kStoodFadesS);
  if (std::abs(longer_s) > std::abs(past_.stood_s)) past_.stood_s = longer_s;
}

// The rival is what is chosen from now on.
void RivalFinder::swap(const TrackSet& tracks, const Support& for_estimate,
                       const Support& for_rival, Rival& rival) {
  past_.turn_round();
  rival.against_map = for_rival.known_static < for_estimate.known_static;
  if (!rival.against_map) return;
  past_.stood_s = 0.0;
  share_out(tracks, rival);
}

Solution RivalFinder::among_unexplained(const TrackSet& tracks, const Eigen::Isometry3d& start) {
  return solver_.solve(tracks.camera, unexplained_, start, tracks.sequence);
}

// What only the other motion explains may be few points, which tell it badly, but are all around as
// the world is. What is far both may explain, and it tells the turn, while what is near and moves
// has no say yet.
void RivalFinder::refine(const TrackSet& tracks, std::span<const TrackRole> roles,
                         const Solution& estimate, Solution& rival) {
  const bool few =
      static_cast<double>(unexplained_.size()) < kFewToTell * static_cast<double>(all_.size());
  if (!few || area_px2(unexplained_) < kAllAround * area_px2(all_)) return;
  gather_unexplained_and_far(roles);
  if (improve(tracks, estimate, unexplained_and_far_, rival))
    static_cast<void>(improve(tracks, estimate, all_, rival));
}

// Takes the motion that `with` has next to the rival's, unless it leads back to the estimate: by
// the cells that this pair alone gives to each of the two.
bool RivalFinder::improve(const TrackSet& tracks, const Solution& estimate,
                          std::span<const Correspondence> with, Solution& rival) {
  const auto cells = [&](const Solution& other) {
    vote(tracks, estimate.T_previous_current, other.T_previous_current, {});
    Support for_estimate;
    Support for_rival;
    count_support(for_estimate, for_rival);
    return std::pair{for_estimate.cells, for_rival.cells};
  };
  const auto [estimates_before, before] = cells(rival);
  const Solution better = solver_.solve_near(tracks.camera, with, rival.T_previous_current);
  if (better.failure != EstimateReason::kNone) return false;
  const auto [estimates, after] = cells(better);
  if (after < kLeastKept * before || after * estimates_before < before * estimates) return false;
  rival = better;
  return true;
}

void RivalFinder::gather_unexplained_and_far(std::span<const TrackRole> roles) {
  depths_m_.clear();
  for (const Correspondence& c : all_) depths_m_.push_back(c.P_previous_m.z());
  const double middle_m = median(depths_m_, 0.0);
  unexplained_and_far_.clear();
  for (std::size_t k = 0; k < all_.size(); ++k) {
    const bool is_far = all_[k].P_previous_m.z() > middle_m;
    if (is_unexplained(roles, k) || (is_far && by_estimate_[k] < kChi2Of3At99Percent))
      unexplained_and_far_.push_back(all_[k]);
  }
}

bool RivalFinder::is_unexplained(std::span<const TrackRole> roles, std::size_t index) const {
  return roles[all_[index].track] == TrackRole::kOutlier && by_estimate_[index] > kUnexplained2;
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
  unexplained_and_far_.reserve(points);
  depths_m_.reserve(points);
  by_estimate_.reserve(points + kResidualLanes);
  by_rival_.reserve(points + kResidualLanes);
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
                         double noise_scale, const Solution& estimate) {
  all_.clear();
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
  }
  whitened_.prepare(tracks.camera, all_, estimate.T_previous_current);
  whitened_.measure_distances2(estimate.T_previous_current.inverse(), by_estimate_);
  unexplained_.clear();
  for (std::size_t k = 0; k < all_.size(); ++k)
    if (is_unexplained(roles, k)) unexplained_.push_back(all_[k]);
}

double RivalFinder::surprise(const Solution& solution, const VelocityPrior& prior) const {
  if (prior.wheels != nullptr) return std::min(prior.wheels->surprise(solution), kMaxSurprise);
  const Vector6d y = velocity_of(solution.T_previous_current, prior.dt_s);
  const Matrix6d to_velocity = motion_perturbation_of_velocity(y, prior.dt_s).inverse();
  const Matrix6d change = diagonal_covariance(config_.acceleration_sigma_mps2 * prior.dt_s,
                                              config_.turn_acceleration_sigma_radps2 * prior.dt_s);
  const Matrix6d S =
      prior.past.covariance + change + to_velocity * solution.covariance * to_velocity.transpose();
  const Vector6d innovation = y - prior.past.y;
  return std::exp(-past_.doubt_s / kHabitLostS) *
         std::min(innovation.dot(S.ldlt().solve(innovation)), kMaxSurpriseOfHabit);
}

// With wheels a mover may own all but little of the image.
bool RivalFinder::prefers(const Support& rival, const Support& estimate, bool has_wheels) const {
  if (!has_wheels && past_.room >= 0.0 && rival.cells > config_.overwhelming_ratio * estimate.cells)
    return true;
  return score(rival) + kPerRoom * beyond_chance(past_.room) + kPerStoodS * past_.stood_s >
         score(estimate);
}

}  // namespace egomod
