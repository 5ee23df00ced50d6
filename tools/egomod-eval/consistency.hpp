// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "detection.hpp"
#include "record.hpp"
#include "statistics.hpp"

namespace egomod::eval {

// Are the published covariances honest? Each is a NEES over its degrees of freedom.
struct ConsistencyFigures {
  std::optional<Consistency> pair;  // motion since the previous pair
  // Motion over 1 s, its covariance from the growth of the pose's; and from the pairs' covariances,
  // composed as if they were independent, which counts the noise of each pose twice.
  std::optional<Consistency> second_by_pose;
  std::optional<Consistency> second_by_pairs;
  std::optional<Consistency> pose;  // since the last reset
  std::optional<Consistency> object_velocity;
  std::optional<Consistency> object_position;
};

[[nodiscard]] ConsistencyFigures score_consistency(const Truth& truth,
                                                   const std::vector<PoseEvidence>& evidence,
                                                   const std::vector<Match>& matches);

}  // namespace egomod::eval
