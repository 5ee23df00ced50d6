// SPDX-License-Identifier: Apache-2.0
#include "decision_cut.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace egomod::fit {
namespace {

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::size_t count_above(const std::vector<double>& ascending, double cut) {
  return static_cast<std::size_t>(ascending.end() -
                                  std::upper_bound(ascending.begin(), ascending.end(), cut));
}

// Where both classes have their values, ascending, each once.
std::vector<double> places(const ClassValues& values) {
  std::vector<double> all;
  std::merge(values.still.begin(), values.still.end(), values.moving.begin(), values.moving.end(),
             std::back_inserter(all));
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

double nearest_in_gap(double from, double to, double present) {
  return present >= from && present < to ? present : 0.5 * (from + to);
}

}  // namespace

void ClassValues::sort() {
  std::sort(still.begin(), still.end());
  std::sort(moving.begin(), moving.end());
}

double ClassValues::share_moving() const {
  return ratio(moving.size(), still.size() + moving.size());
}

double Score::precision() const { return ratio(true_positives, true_positives + false_positives); }
double Score::recall() const { return ratio(true_positives, true_positives + false_negatives); }
double Score::f1() const {
  return ratio(2 * true_positives, 2 * true_positives + false_positives + false_negatives);
}

Score score_above(const ClassValues& values, double cut) {
  const std::size_t found = count_above(values.moving, cut);
  return {.true_positives = found,
          .false_positives = count_above(values.still, cut),
          .false_negatives = values.moving.size() - found};
}

std::optional<double> best_cut(const ClassValues& values, double prior_moving, double present) {
  if (values.still.empty() || values.moving.empty()) return std::nullopt;
  const std::vector<double> all = places(values);
  // Of one answer for all; what is as good to rounding is not better.
  double least = std::min(prior_moving, 1.0 - prior_moving) * (1.0 - 1e-12);
  std::optional<double> best;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    const Score score = score_above(values, all[i]);
    const double risk = prior_moving * ratio(score.false_negatives, values.moving.size()) +
                        (1.0 - prior_moving) * ratio(score.false_positives, values.still.size());
    const double cut = nearest_in_gap(all[i], all[i + 1], present);
    const bool ties = best && std::abs(risk - least) <= 1e-12;
    if (ties ? std::abs(cut - present) < std::abs(*best - present) : risk < least) {
      best = cut;
      least = risk;
    }
  }
  return best;
}

}  // namespace egomod::fit
