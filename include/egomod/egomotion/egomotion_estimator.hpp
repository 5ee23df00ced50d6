// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/egomotion/correspondence.hpp"
#include "egomod/egomotion/error_growth.hpp"
#include "egomod/egomotion/gauss_newton_solver.hpp"
#include "egomod/egomotion/interval_watch.hpp"
#include "egomod/egomotion/pose_accumulator.hpp"
#include "egomod/egomotion/readout.hpp"
#include "egomod/egomotion/rival_finder.hpp"
#include "egomod/egomotion/sigma_point_solver.hpp"
#include "egomod/egomotion/solution.hpp"
#include "egomod/egomotion/statistics.hpp"
#include "egomod/egomotion/track_map.hpp"
#include "egomod/egomotion/wheels_prior.hpp"

namespace egomod {

enum class EgomotionMethod { kSigmaPointKalmanFilter, kGaussNewton };

struct EgomotionConfig {
  EgomotionMethod method = EgomotionMethod::kGaussNewton;
  // true: against each track's position filtered over its life; false: frame to frame.
  bool map = true;

  int min_inliers = 8;
  double min_inlier_share = 0.15;
  // Worst standard deviation of a motion still called determined.
  double max_translation_sigma_m = 0.5;
  double max_rotation_sigma_rad = 0.05;
  // Gauss-Newton: squared Mahalanobis distance that parts inliers from outliers.
  double inlier_chi2 = kChi2Of3At99Percent;
  // What a reset without knowledge of the motion adds to the pose.
  double reset_translation_sigma_m = 1.0;
  double reset_rotation_sigma_rad = 0.2;

  RansacConfig ransac;
  GaussNewtonConfig gauss_newton;
  SigmaPointFilterConfig sigma_point_filter;
  TrackMapConfig track_map;
  RivalConfig rival;
  WheelsConfig wheels;
};

// Motion of the rig between two tracked pairs from the tracks seen in both, robust against movers,
// and its accumulation into a pose. Threads: one caller.
class EgomotionEstimator {
 public:
  explicit EgomotionEstimator(const EgomotionConfig& config);

  // `motion` is refilled in place; `motion.roles` runs parallel to `tracks.tracks`.
  void estimate(const TrackSet& tracks, Egomotion& motion);

 private:
  void begin(const TrackSet& tracks, Egomotion& motion) const;
  void repeat_pose(const TrackSet& tracks, Egomotion& motion);
  [[nodiscard]] EstimateReason reason_to_start_anew(const TrackSet& tracks) const;
  void start_anew(EstimateReason reason, const TrackSet& tracks, Egomotion& motion);
  void follow(const TrackSet& tracks, Egomotion& motion);
  void finish(Egomotion& motion) const;

  void advance_to(const TrackSet& tracks, Egomotion& motion);
  void gather(const TrackSet& tracks);
  [[nodiscard]] bool is_cut_off(const TrackSet& tracks) const;
  [[nodiscard]] std::size_t unknown_tracks(const TrackSet& tracks) const;
  [[nodiscard]] bool find_past(const StereoCamera& camera, const Track& track, std::size_t index,
                               const Eigen::Isometry3d& T_previous_first, Correspondence& c) const;
  [[nodiscard]] Solution solve(const TrackSet& tracks);
  [[nodiscard]] std::span<const MapPoint> known_points() const;
  [[nodiscard]] bool rests() const;
  [[nodiscard]] bool learns_readout() const;
  void account_for_rows(const TrackSet& tracks, Solution& solution);
  void learn_readout(const TrackSet& tracks, const Solution& solution, bool is_told);
  void assign_roles(const TrackSet& tracks, const Solution& solution, Egomotion& motion);
  [[nodiscard]] bool is_inlier(const Eigen::Isometry3d& T_current_previous, std::size_t k,
                               const StereoCamera& camera) const;
  [[nodiscard]] EstimateReason judge(const Solution& solution, const Egomotion& motion) const;
  [[nodiscard]] bool weigh_rival(const TrackSet& tracks, Solution& solution, Solution& other,
                                 Egomotion& motion);
  [[nodiscard]] bool wheels_contradict(const Solution& solution, const Egomotion& motion) const;
  [[nodiscard]] int least_inliers(int outliers) const;
  [[nodiscard]] bool is_surely_static(const Egomotion& motion) const;
  void accept(const TrackSet& tracks, const Solution& solution, bool has_rival, bool contradicted,
              Egomotion& motion);
  void doubt(const Solution& other, EstimateReason reason, Egomotion& motion);
  void fail(EstimateReason reason, const TrackSet& tracks, Egomotion& motion);

  void keep_velocity(const Egomotion& motion);
  void adapt_noise_scale();
  void note_common_error();
  [[nodiscard]] Matrix6d unknown_motion() const;
  [[nodiscard]] VelocityState unknown_velocity() const;
  void watch_for_holes(const TrackSet& tracks);

  EgomotionConfig config_;
  GaussNewtonSolver gauss_newton_;
  SigmaPointSolver sigma_point_;
  RivalFinder rival_finder_;
  Rival rival_;
  WheelsPrior wheels_prior_;
  std::optional<WheelsMotion> wheels_;  // of this pair
  TrackMap map_;
  ReadoutLearner readout_;
  PairVelocity pair_velocity_;
  RowTiming rows_;                 // of this pair
  bool is_first_motion_ = true;    // since the map was begun
  LastingError error_of_readout_;  // that a second of readout makes
  ScaleDoubt scale_doubt_;
  PoseAccumulator pose_;
  // Of the last pose against the map: white, and part of the next motion's error. Zero without map.
  Matrix6d against_map_ = Matrix6d::Zero();
  // How far off the pose is, should the other motion have been the rig's ever since geometry could
  // not tell them apart; zero when it can.
  Vector6d to_other_pose_ = Vector6d::Zero();
  VelocityState velocity_;
  VelocityState habit_;  // the velocity, slowly followed: what constant motion means to a rival
  double noise_scale_ = 1.0;  // of the observations' covariances, learnt from the residuals
  ErrorGrowth error_growth_;

  bool started_ = false;
  StereoCamera camera_;
  bool is_lost_ = false;        // what is known of the past can no longer be used
  int contradicted_pairs_ = 0;  // in a row, that no motion against the map explains
  int explained_pairs_ = 0;     // since the map was begun
  bool has_velocity_ = false;
  std::uint64_t last_tracked_sequence_ = 0;
  std::uint64_t skipped_ = 0;  // by capture.max_rate_hz since then
  IntervalWatch interval_watch_;
  bool after_hole_ = false;            // no motion was found since pairs were missing
  Nanoseconds map_exposure_{0};        // of the pair that the map was aligned to
  Nanoseconds start_exposure_{0};      // of the pair that the map began with
  Nanoseconds reference_exposure_{0};  // of the pair that motions are measured from
  double dt_s_ = 0.0;

  std::vector<Correspondence> correspondences_;
  std::vector<double> distances2_;  // of the correspondences, under the solution
  std::vector<double> scratch_;
};

}  // namespace egomod
