// SPDX-License-Identifier: Apache-2.0
#include "statistics.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::eval {
namespace {

// 95 % quantiles of chi-square.
constexpr double kChiSquare95Of3 = 7.8147;
constexpr double kChiSquare95Of6 = 12.5916;

double quantile(const std::vector<double>& ascending, double share) {
  const double at = share * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, ascending.size() - 1);
  return ascending[below] +
         (at - static_cast<double>(below)) * (ascending[above] - ascending[below]);
}

}  // namespace

std::optional<Summary> summarise(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(values.size());
  return Summary{.count = values.size(),
                 .median = quantile(values, 0.5),
                 .mean = sum / count,
                 .rmse = std::sqrt(squares / count),
                 .p90 = quantile(values, 0.9),
                 .p99 = quantile(values, 0.99),
                 .max = values.back()};
}

std::optional<Consistency> consistency(const std::vector<double>& nees, int dof) {
  const auto summary = summarise(nees);
  if (!summary) return std::nullopt;
  const double bound = dof == 3 ? kChiSquare95Of3 : kChiSquare95Of6;
  const auto within =
      std::count_if(nees.begin(), nees.end(), [&](double value) { return value <= bound; });
  return Consistency{
      .count = summary->count,
      .dof = dof,
      .mean_per_dof = summary->mean / dof,
      .median_per_dof = summary->median / dof,
      .within_95 = static_cast<double>(within) / static_cast<double>(summary->count)};
}

}  // namespace egomod::eval
