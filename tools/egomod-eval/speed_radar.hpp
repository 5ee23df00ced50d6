// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "detection.hpp"

namespace egomod::eval {

// How fast something was, and how fast it was said to be, over the pairs in which it was found.
struct SpeedFigures {
  std::size_t pairs = 0;
  double true_mps = 0.0, mean_mps = 0.0;  // means over the pairs
  double rmse_mps = 0.0;
  // Of a record, and where standard errors are above 0: their mean, the share of pairs within one
  // of them (honest: 0.68), the mean of error² over variance (honest: 1).
  std::optional<double> sigma_mps;
  std::optional<double> within_sigma;
  std::optional<double> error2_by_variance;

  [[nodiscard]] std::optional<double> sigma_kmh() const;
};

struct SpeedRadar {
  std::map<std::string, SpeedFigures> objects;  // by the true object
  SpeedFigures all;
};

// Nothing where no speed is known.
[[nodiscard]] std::optional<SpeedRadar> score_speeds(const std::vector<Match>& matches);

}  // namespace egomod::eval
