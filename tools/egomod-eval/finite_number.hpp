// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

namespace egomod {

// Before CLI11's own checks of a range, which nan passes.
[[nodiscard]] inline CLI::Validator finite_number() {
  return {[](std::string& text) {
            const bool finite = std::isfinite(std::strtod(text.c_str(), nullptr));
            return finite ? std::string() : "'" + text + "' is not a finite number";
          },
          "", "finite"};
}

}  // namespace egomod
