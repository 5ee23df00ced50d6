// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "pixel_truth.hpp"
#include "sequence.hpp"

namespace egomod::eval {

// Whether points lie on what moves: by the truth's masks, where there are any, else by the
// rectangles and depths of its objects. Threads: one caller.
class PointTruth {
 public:
  // Keeps a reference to `truth`, of which the objects must be known.
  explicit PointTruth(const Truth& truth);

  // Nothing at an object's edge, or in a mover's rectangle but not at its depth. Throws InputError.
  [[nodiscard]] std::optional<bool> moves(const PointEvidence& point);

 private:
  const Truth& truth_;
  std::optional<PixelTruth> pixels_;
};

}  // namespace egomod::eval
