// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace egomod {

inline constexpr std::size_t kFilterLanes = 4;

inline constexpr double kLeastEvidence = -6.0;
inline constexpr double kMostEvidence = 25.0;
inline constexpr double kMostPerPair = 6.0;  // evidence: no single measurement convinces

// How long an acceleration lasts: the moving model's velocity gathers variance by its square and
// this. A manoeuvre shows as misfit before it shows in the velocity, and raises the acceleration.
inline constexpr double kAccelerationTime_s = 1.0 / 30.0;
inline constexpr double kFittingChi2 = 3.0;
inline constexpr double kMostAgility = 6.0;

// Symmetric 3x3 matrices are their lower triangle, row by row.
using Lanes = double[kFilterLanes];

// Points under two beliefs at once, "it stands" and "it moves with its velocity" (U. Franke,
// C. Rabe, H. Badino, S. Gehrig, 6D-Vision, DAGM 2005), and what speaks for the second: the log
// ratio of how well each foretold the measurements. The moving one starts with a broad velocity
// and so foretells less sharply: noise alone speaks for "it stands", without a speed threshold.
// A point's disparity has an unknown constant error b, which is considered, not estimated
// (S. Schmidt's filter): `bias` is each state's covariance with one sigma of it.
struct alignas(32) FilterBlock {
  Lanes standing_position[3];
  Lanes standing_covariance[6];
  Lanes standing_bias[3];
  Lanes position[3];
  Lanes velocity[3];
  Lanes position_covariance[6];
  Lanes cross_covariance[9];  // position in rows, velocity in columns
  Lanes velocity_covariance[6];
  Lanes bias[6];
  Lanes uvd_px[3];      // last measured
  Lanes evidence;       // log likelihood ratio, moving over standing
  Lanes misfit;         // running mean of the moving model's chi-square, 3 for one that fits
  Lanes standing_chi2;  // of the last update
  Lanes updates;        // 0: never seen
  Lanes stood;          // not 0: the moving model has learnt to rest
  std::int64_t seen_ns[kFilterLanes];
  std::int64_t fresh_ns[kFilterLanes];  // since when the moving model has learnt its velocity
};

// One pair's view of the points of a block.
struct alignas(32) MeasurementBlock {
  Lanes is_seen;  // 0: the rest is of no meaning, and the filter stays as it is
  Lanes uvd_px[3];
  Lanes covariance_px2[6];  // of this pair alone
  Lanes reanchored_px;      // how far a renewed template may have stepped
};

// What the filters say of the points of a block, in this pair's camera axes.
struct alignas(32) PointBlock {
  Lanes position_m[3];
  Lanes position_covariance_m2[6];
  Lanes velocity_mps[3];
  Lanes velocity_covariance_m2ps2[6];
  Lanes chi2;                     // of the velocity against rest, 3 degrees of freedom
  Lanes standing_residual_px[3];  // of (u, v, disparity) against where the standing point was due
};

struct MotionPrior {
  double velocity_mps = 1.5;       // standard deviation along each axis, of a point never seen
  double acceleration_mps2 = 0.3;  // of anything that moves
  double manoeuvre_hz = 0.2;       // and in proportion to its speed: what is fast turns fast
};

// Matrices row by row.
struct FilterStep {
  double R_first_current[3][3];
  double t_first_current_m[3];
  double R_current_first[3][3];
  double t_current_first_m[3];
  // Of the motion since the previous pair, in the first camera's axes.
  double translation_covariance[6];
  double cross_covariance[3][3];
  double rotation_covariance[3][3];
  double fx_px, fy_px, cx_px, cy_px, fx_baseline_px_m;
  double disparity_bias_px, flow_error_share, walk_px;
  MotionPrior prior;
  std::int64_t now_ns;
  bool is_slow;  // pairs are so far apart that one displacement shows motion by itself
};

struct FilterKernels {
  // Predicts, measures and updates the filters that are seen, and starts the new ones of them.
  void (*step)(const FilterStep&, const MeasurementBlock&, FilterBlock&, PointBlock&);
};

namespace baseline {
FilterKernels filter_kernels();
}
namespace x86_64_v3 {
FilterKernels filter_kernels();
}

// Those of this machine.
[[nodiscard]] FilterKernels filter_kernels();

}  // namespace egomod
