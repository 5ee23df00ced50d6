// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace egomod {

enum class MovingObjectsMethod {
  kThesis,  // two pairs, RANSAC outliers, one speed threshold: Abaabu, sections IV-A to IV-C
  kLag,     // every pair against one a fraction of a second before it, whitened by the noise
  kFilter,  // every track filtered under "stands" and "moves", evidence summed over time
};

struct MovingObjectsConfig {
  MovingObjectsMethod method = MovingObjectsMethod::kFilter;

  // --- method thesis ---
  // A point faster than this moves. 0: where the posterior of the Rayleigh pair below reaches
  // `decision_probability`. 0.2385 is the published 50 % threshold.
  double threshold_mps = 0.2385;
  // Rayleigh scales of the speeds of static and of moving points. The published ones are lost;
  // these two meet at the published threshold. `egomod-fit` estimates them from labelled
  // velocities.
  double sigma_static_mps = 0.1112;
  double sigma_moving_mps = 0.300;
  double prior_moving = 0.5;
  double decision_probability = 0.5;
  // Each velocity component is rounded to a multiple of this. Wide enough that the depth noise of
  // one object at 4 m and 5 Hz (0.14 m/s, one sigma) stays within neighbouring bins.
  double velocity_bin_mps = 0.5;
  // Two points have "the same velocity" when no component is more than this many bins apart.
  // 0 is the letter of the thesis; 1 keeps an object whole that straddles the edge of a bin.
  int velocity_bin_reach = 1;
  // Chains of points no further apart than this belong together.
  double group_distance_m = 0.3;
  int group_min_points = 8;

  // --- method lag ---
  // The pair compared with: the nearest to `lag_s`, within [min_lag_s, max_lag_s].
  double lag_s = 0.4;
  double min_lag_s = 0.2;
  double max_lag_s = 1.0;
  // A point moves when its whitened displacement passes the chi-square (3 dof) gate and it is
  // faster than `min_speed_mps`; it is static below `static_chi2`.
  double moving_chi2 = 16.27;  // 99.9 %
  double static_chi2 = 7.81;   // 95 %
  double min_speed_mps = 0.15;
  double max_depth_m = 40.0;
  // Added to the variances of each observation: what no single image tells (track drift).
  double noise_floor_px = 0.05;
  // Disparity error that a point keeps over the lag (calibration, slanted patches): it feigns
  // motion in proportion to the rig's own.
  double disparity_bias_px = 0.1;
  // Systematic error of a static point's path through the image (calibration, rectification, the
  // rig's rotation), as a share of the path's length.
  double flow_error_share = 0.01;
  // A priori speed of movers along each axis, for the motion probability.
  double velocity_prior_mps = 1.5;
  // Neighbours in an object: nearer than this across the line of sight, or than this in the image.
  double neighbour_distance_m = 0.4;
  double neighbour_distance_px = 35.0;
  double neighbour_depth_m = 0.5;  // plus 2.5 sigma of both depths
  int min_points = 5;
  // Least share of the tracks inside an object's rectangle and depth that move.
  double min_purity = 0.5;
  // Correlation of the errors of an object's points: averaging K gives sigma^2 (rho + (1 - rho)/K).
  double error_correlation = 0.2;
  // Least chi-square of an object's mean velocity; it must exceed `min_speed_mps`, too.
  double object_chi2 = 25.0;
  // A new object is MOVING after evidence in this many pairs over at least this time.
  int confirm_pairs = 3;
  double confirm_s = 0.1;
  // Without evidence an object coasts this long.
  double coast_s = 2.0;

  // --- method filter (and, of those above, depth, noise, prior, neighbours, gates, coasting) ---
  // Process noise of a mover's velocity: constant, plus in proportion to its speed.
  double acceleration_mps2 = 0.3;
  double manoeuvre_hz = 0.2;
  // A track strays this far in the left image from pair to pair.
  double walk_px = 0.033;
  // Log likelihood ratio of a group's points together from which it becomes an object, and, as a
  // leaky sum over pairs, MOVING.
  double min_evidence = 12.0;
  double confirm_evidence = 60.0;
};

}  // namespace egomod
