// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "evaluation.hpp"

namespace egomod::eval {

struct HtmlReport {
  std::string text;     // one page that needs no other file
  std::string warning;  // why it has no figures; empty: it has them
};

[[nodiscard]] HtmlReport html_report(const std::vector<Evaluation>& evaluations);

}  // namespace egomod::eval
