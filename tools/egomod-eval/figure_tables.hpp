// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "evaluation.hpp"

namespace egomod::eval {

// What both reports show; the first column names the row.
struct FigureTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

[[nodiscard]] std::vector<FigureTable> figure_tables(const Evaluation& evaluation);
// One row a run, and the mean where there are several.
[[nodiscard]] FigureTable overview(const std::vector<Evaluation>& evaluations);
// The same figures of one run, in a list.
[[nodiscard]] FigureTable headlines(const Evaluation& evaluation);
// "-" where there is none.
[[nodiscard]] std::string number(const std::optional<double>& value, int decimals);

// Columns aligned, for a terminal.
[[nodiscard]] std::string text_of(const FigureTable& table);

}  // namespace egomod::eval
