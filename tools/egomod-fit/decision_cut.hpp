// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

namespace egomod::fit {

// What a decision goes by, of what rests and of what moves. Each class ascends once sorted.
struct ClassValues {
  std::vector<double> still, moving;

  void add(bool moves, double value) { (moves ? moving : still).push_back(value); }
  void sort();
  [[nodiscard]] double share_moving() const;
};

struct Score {
  std::size_t true_positives = 0, false_positives = 0, false_negatives = 0;

  [[nodiscard]] double precision() const;  // 1 where nothing is said to move
  [[nodiscard]] double recall() const;     // 1 where nothing moves
  [[nodiscard]] double f1() const;
};

// Of "moves above `cut`"; `values` are sorted.
[[nodiscard]] Score score_above(const ClassValues& values, double cut);

// Bayes's choice between the measured distributions: the cut of the least
// prior * (share of the moving below) + (1 - prior) * (share of the still above). Any cut between
// two neighbours decides alike: `present` where it is among the best, else the middle of the gap
// nearest to it. Nothing where a class has no values, or no cut beats giving one answer for all.
[[nodiscard]] std::optional<double> best_cut(const ClassValues& values, double prior_moving,
                                             double present);

}  // namespace egomod::fit
