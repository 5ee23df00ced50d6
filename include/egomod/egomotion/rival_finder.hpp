// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/egomotion/gauss_newton_solver.hpp"
#include "egomod/egomotion/sigma_point_filter.hpp"
#include "egomod/egomotion/solution.hpp"
#include "egomod/egomotion/track_map.hpp"
#include "egomod/egomotion/wheels_prior.hpp"

namespace egomod {

struct RivalConfig {
  // From this much support on for each that the estimate alone has, a second motion makes the
  // estimate ambiguous: 0.55 is a mover on 35 % of the image that tells the two apart, or the
  // world on no more than that.
  double min_support_ratio = 0.55;
  double ratio_to_stay = 0.35;  // the same once it is ambiguous
  // A motion with this much support for each of the other's is the world's, whatever the past.
  double overwhelming_ratio = 5.0;
  // How a rig may change its velocity: decides between motions that are about equally supported.
  double acceleration_sigma_mps2 = 1.0;
  double turn_acceleration_sigma_radps2 = 1.0;
};

// What speaks for one of two motions; only tracks that the other does not explain count. Cells of
// the image vote, each once however many tracks it has: the world is all around, while a mover with
// a rich texture is in one place.
struct Support {
  double cells = 0.0;
  double known_static = 0.0;  // of them, weighted by how long and how surely they stood still
  double cells_with_followed = 0.0;  // also by tracks whose past tells the two apart
  double stood = 0.0;                // of those, pairs without doubt that they stood still in
  double surprise = 0.0;             // squared Mahalanobis distance from what the prior expects
};

// What is known of the rig's motion besides what this pair shows: its velocity `dt_s` ago or, where
// there are wheels, what they saw.
struct VelocityPrior {
  const VelocityState& past;
  double dt_s = 0.0;
  const WheelsMotion* wheels = nullptr;
};

struct Rival {
  Solution solution;  // of the second motion, between the last two pairs
  bool preferred = false;
  // Preferred although the map knows the other one's points better; then `shares` says of each
  // track how surely it belongs to the rival.
  bool against_map = false;
  std::vector<double> shares;
};

// When movers own many tracks, geometry cannot tell whether they move or the rig does. Looks for
// one motion that explains the tracks which the estimate does not, and weighs it against the
// estimate by the past: tracks known to stand still, and constant velocity or the wheels; and by
// room: a mover is in one place, while the world is all around it and behind it. When the wheels
// contradict the estimate it looks for far less: any motion that they confirm. Threads: one caller.
class RivalFinder {
 public:
  RivalFinder(const RivalConfig& config, const GaussNewtonConfig& gauss_newton,
              const RansacConfig& ransac)
      : config_(config), solver_(gauss_newton, ransac), whitened_(gauss_newton) {}

  // `roles`: which tracks `estimate` explains; `map` is empty without one. False when no other
  // motion comes near.
  [[nodiscard]] bool find(const TrackSet& tracks, const Solution& estimate,
                          std::span<const TrackRole> roles, std::span<const MapPoint> map,
                          double noise_scale, const VelocityPrior& prior, Rival& rival);

  // After a pair that failed: no motion can be told then, and one that was there has not gone away.
  // `other`: how it goes on for `dt_s`.
  [[nodiscard]] bool goes_on(const Solution& estimate, double dt_s, Solution& other) const;

  // Whether another motion came near in the last pair.
  [[nodiscard]] bool is_in_doubt() const { return found_; }

  void reset() {
    found_ = false;
    past_ = {};
  }

 private:
  // What a second motion needs to count.
  struct Least {
    std::size_t tracks;
    double share;  // of all cells, that tell the two motions apart
    double ratio;  // of its support to the estimate's
  };
  // What the pairs so far say of the two motions; the ratios are the rival's to the estimate's.
  struct Past {
    Vector6d chosen = Vector6d::Zero();  // velocity in the last pair, and of the other motion
    Vector6d other = Vector6d::Zero();
    double room = 0.0;     // logarithm of the ratio
    double stood_s = 0.0;  // how much longer its points are known to have stood still
    double doubt_s = 0.0;  // how long there have been two
    int pairs = 0;         // that told

    void turn_round() {
      room = -room;
      stood_s = -stood_s;
    }
  };
  enum class Side : std::uint8_t { kNone, kEstimate, kRival };
  [[nodiscard]] Least least() const;
  [[nodiscard]] bool search(const TrackSet& tracks, const Solution& estimate,
                            std::span<const TrackRole> roles, std::span<const MapPoint> map,
                            double noise_scale, const VelocityPrior& prior, Rival& rival);
  // Whether the last other motion is so far from the estimate that no pair would miss it.
  [[nodiscard]] bool shows_in_one_pair(const Solution& estimate, double dt_s) const;
  [[nodiscard]] bool lingers(const TrackSet& tracks, std::span<const MapPoint> map);
  [[nodiscard]] Solution among_unexplained(const TrackSet& tracks, const Eigen::Isometry3d& start);
  void refine(const TrackSet& tracks, std::span<const TrackRole> roles, const Solution& estimate,
              Solution& rival);
  // An element of `all_`.
  [[nodiscard]] bool is_unexplained(std::span<const TrackRole> roles, std::size_t index) const;
  void gather_unexplained_and_far(std::span<const TrackRole> roles);
  [[nodiscard]] bool improve(const TrackSet& tracks, const Solution& estimate,
                             std::span<const Correspondence> with, Solution& rival);
  [[nodiscard]] Solution confirmed(const TrackSet& tracks, const Solution& estimate,
                                   const WheelsMotion& wheels);
  void reserve(std::size_t points);
  [[nodiscard]] bool enough_outliers(const TrackSet& tracks, std::span<const TrackRole> roles);
  void gather(const TrackSet& tracks, std::span<const TrackRole> roles, double noise_scale,
              const Solution& estimate);
  [[nodiscard]] static Side followed(const MapPoint& point, const Eigen::Vector2d& apart_px);
  void vote(const TrackSet& tracks, const Eigen::Isometry3d& T_estimate,
            const Eigen::Isometry3d& T_rival, std::span<const MapPoint> map);
  void count_support(Support& estimate, Support& rival) const;
  [[nodiscard]] double log_room(bool of_rival) const;
  void weigh_past(const Solution& estimate, const Solution& rival, double dt_s,
                  const Support& for_estimate, const Support& for_rival);
  void forget(double dt_s);
  void swap(const TrackSet& tracks, const Support& for_estimate, const Support& for_rival,
            Rival& rival);
  void share_out(const TrackSet& tracks, Rival& rival);
  [[nodiscard]] double surprise(const Solution& solution, const VelocityPrior& prior) const;
  [[nodiscard]] bool prefers(const Support& rival, const Support& estimate, bool has_wheels) const;

  struct Votes {
    int tracks = 0;
    double knowledge = 0.0;
    int with_followed = 0;   // and those that the pair does not tell apart, but their past does
    int stood = 0;           // of those
    double log_depth = 0.0;  // the sum of those
  };
  struct Cell {
    int tracks = 0;
    Votes estimate;
    Votes rival;
  };
  void clear_cells() { cells_.fill({}); }
  [[nodiscard]] Cell& cell_of(const StereoCamera& camera, const Eigen::Vector3d& observed_px);
  [[nodiscard]] double occupied_cells() const;

  RivalConfig config_;
  bool found_ = false;        // in the last pair
  Solution last_;             // of the motion that was not chosen then
  bool is_measured_ = false;  // in this pair
  Past past_;
  bool is_suspected_ = false;  // the estimate, by the wheels
  static constexpr int kColumns = 16;
  static constexpr int kRows = 12;
  std::array<Cell, static_cast<std::size_t>(kColumns* kRows)> cells_;
  GaussNewtonSolver solver_;
  RobustGaussNewton whitened_;
  std::vector<double> by_estimate_;  // squared distances of all
  std::vector<double> by_rival_;
  std::vector<Correspondence> all_;  // of the last two pairs
  std::vector<Correspondence> unexplained_;
  std::vector<Correspondence> unexplained_and_far_;
  std::vector<double> depths_m_;
};

}  // namespace egomod
