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
// One row a run, for docs: what a reader asks first, and mean and median of each method at the end.
[[nodiscard]] FigureTable method_table(const std::vector<Evaluation>& evaluations);
// The figures of the overview, of one run, in a list.
[[nodiscard]] FigureTable headlines(const Evaluation& evaluation);
// "-" where there is none.
[[nodiscard]] std::string number(const std::optional<double>& value, int decimals);

[[nodiscard]] std::string markdown_of(const FigureTable& table);
// Columns aligned, for a terminal.
[[nodiscard]] std::string text_of(const FigureTable& table);

}  // namespace egomod::eval
