// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "egomod/core/instruction_set.hpp"

namespace egomod {

inline constexpr std::size_t kResidualLanes = 4;
inline constexpr std::size_t kResidualColumns = 13;

// What residuals are made of, one column a quantity, `count` a multiple of kResidualLanes. Places
// behind the last point have weight zero, and so has everything else of them but z.
struct ResidualColumns {
  enum Column : std::size_t { kX, kY, kZ, kU, kV, kD, kWhitening, kWeight = kWhitening + 6 };
  const double* column[kResidualColumns];
  std::size_t count;
};

// The motion T_current_previous, row by row, and the camera.
struct ResidualGeometry {
  double R[9];
  double t_m[3];
  double fx_px, fy_px, cx_px, cy_px, fx_baseline_px_m;
  double min_depth_m;
  double behind_distance2;  // of points nearer than that
};

// A (6x6, lower triangle in rows) and b of A xi = b.
struct NormalSums {
  double A[21];
  double b[6];
};

struct ResidualKernels {
  // Squared Mahalanobis distance of each point.
  void (*distances2)(const ResidualColumns&, const ResidualGeometry&, double* distances2);
  // Normal equations in a right perturbation of T_previous_current, weights (k / (k + q))^2 of
  // Geman-McClure; k = infinity: least squares. Writes the squared distances q too.
  void (*accumulate)(const ResidualColumns&, const ResidualGeometry&, double kernel,
                     double* distances2, NormalSums& sums);
  // The same with the weights given, instead of those of the points.
  void (*accumulate_weighted)(const ResidualColumns&, const ResidualGeometry&,
                              const double* weights, NormalSums& sums);
};

namespace baseline {
ResidualKernels residual_kernels();
}
namespace x86_64_v3 {
ResidualKernels residual_kernels();
}

[[nodiscard]] inline ResidualKernels residual_kernels() {
#if defined(EGOMOD_HAS_X86_64_V3)
  if (instruction_set() >= InstructionSet::kX86_64V3) return x86_64_v3::residual_kernels();
#endif
  return baseline::residual_kernels();
}

}  // namespace egomod
