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
  double surprise = 0.0;      // squared Mahalanobis distance from what the prior expects
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
};

// When movers own many tracks, geometry cannot tell whether they move or the rig does. Looks for
// one motion that explains the tracks which the estimate does not, and weighs it against the
// estimate by the past: tracks known to stand still, and constant velocity or the wheels. When the
// wheels contradict the estimate it looks for far less: any motion that they confirm. Threads: one
// caller.
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

  void reset() { found_ = false; }

 private:
  // What a second motion needs to count.
  struct Least {
    std::size_t tracks;
    double share;  // of all cells, that tell the two motions apart
    double ratio;  // of its support to the estimate's
  };
  [[nodiscard]] Least least() const;
  [[nodiscard]] bool search(const TrackSet& tracks, const Solution& estimate,
                            std::span<const TrackRole> roles, std::span<const MapPoint> map,
                            double noise_scale, const VelocityPrior& prior, Rival& rival);
  [[nodiscard]] bool lingers(const TrackSet& tracks, std::span<const MapPoint> map);
  [[nodiscard]] Solution among_unexplained(const TrackSet& tracks, const Eigen::Isometry3d& start);
  [[nodiscard]] Solution confirmed(const TrackSet& tracks, const Solution& estimate,
                                   const WheelsMotion& wheels);
  void reserve(std::size_t points);
  [[nodiscard]] bool enough_outliers(const TrackSet& tracks, std::span<const TrackRole> roles);
  void gather(const TrackSet& tracks, std::span<const TrackRole> roles, double noise_scale);
  void vote(const TrackSet& tracks, const Eigen::Isometry3d& T_estimate,
            const Eigen::Isometry3d& T_rival, std::span<const MapPoint> map);
  void count_support(Support& estimate, Support& rival) const;
  [[nodiscard]] double surprise(const Solution& solution, const VelocityPrior& prior) const;
  [[nodiscard]] bool prefers(const Support& rival, const Support& estimate, bool has_wheels) const;

  struct Votes {
    int tracks = 0;
    double knowledge = 0.0;
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
  bool found_ = false;  // in the last pair
  Solution last_;       // of the rival then
  double last_dt_s_ = 0.0;
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
};

}  // namespace egomod
