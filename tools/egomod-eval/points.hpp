// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "record.hpp"

namespace egomod::eval {

struct RocPoint {
  double threshold_mps = 0.0;
  double false_positive_rate = 0.0;
  double true_positive_rate = 0.0;
};

// Points with a known velocity against what they lie on: by the truth's masks, where there are any,
// else by the rectangles and depths of its objects. The curve sweeps a threshold on speed; the
// counts are those of the points' own decision.
struct PointFigures {
  int moving = 0, still = 0;  // in truth
  int left_out = 0;           // at an object's edge, or in a mover's rectangle but not at its depth
  int tp = 0, fp = 0, fn = 0;
  std::optional<double> precision, recall, f1;
  double false_positive_rate = 0.0;
  std::optional<double> area;  // under the curve
  std::vector<RocPoint> curve;
};

[[nodiscard]] PointFigures score_points(const Truth& truth,
                                        const std::vector<PointEvidence>& points, int first_frame);

}  // namespace egomod::eval
