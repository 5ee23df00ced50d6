// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace egomod {

struct TextLine {
  int number = 0;  // from 1
  std::string text;
};

// "file:line", as compilers print it.
[[nodiscard]] std::string at(const std::filesystem::path& file, int line);

// What a file holds, fit for a message on a terminal: other bytes than printable ASCII as \xNN, not
// too long.
[[nodiscard]] std::string shown(std::string_view text);

// Lines that hold something, without white space at either end. Throws SourceError.
[[nodiscard]] std::vector<TextLine> read_lines(const std::filesystem::path& file);

// Finite numbers separated by white space. Throws SourceError
// that begins with `where`.
[[nodiscard]] std::vector<double> parse_numbers(std::string_view text, const std::string& where);

// Decimal integer, nothing around it. Throws SourceError that begins with `where`.
[[nodiscard]] long long parse_integer(std::string_view text, const std::string& where);

[[nodiscard]] std::string_view trimmed(std::string_view text);

}  // namespace egomod
