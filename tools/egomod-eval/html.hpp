// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "evaluation.hpp"
#include "figure.hpp"
#include "figure_tables.hpp"

namespace egomod::eval {

struct HtmlReport {
  std::string text;     // one page that needs no other file
  std::string warning;  // why it has no figures; empty: it has them
};

// Pieces of a page, for other reports.
[[nodiscard]] std::string html_page(const std::string& title, const std::string& body);
[[nodiscard]] std::string html_of(const FigureTable& table);
[[nodiscard]] std::string html_of(const Plot& plot);
[[nodiscard]] std::string html_escaped(const std::string& text);

[[nodiscard]] HtmlReport html_report(const std::vector<Evaluation>& evaluations);

}  // namespace egomod::eval
