// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "egomod/app/config.hpp"

namespace egomod {

// An enumeration, its names in the order of its values.
struct Choice {
  int (*get)(const Config&);
  void (*set)(Config&, int);
  std::span<const std::string_view> names;
};

// Where in Config an option lives, and of which type it is.
using Field = std::variant<double& (*)(Config&), int& (*)(Config&), std::uint32_t& (*)(Config&),
                           bool& (*)(Config&), std::string& (*)(Config&), Choice>;

// One row serves file, command line, dump and check.
struct Option {
  std::string_view key;  // section.key; a section may have a dot of its own
  Field field;
  std::string_view help;
  double min = 0.0;  // numbers only, inclusive
  double max = 0.0;
  std::string_view unit{};

  [[nodiscard]] std::string_view section() const { return key.substr(0, key.rfind('.')); }
  [[nodiscard]] std::string_view name() const { return key.substr(key.rfind('.') + 1); }
};

// All options, those of a section together, sections in the order of the pipeline.
[[nodiscard]] std::span<const Option> options();

}  // namespace egomod
