// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace egomod::eval {

// A file that cannot be used: names file, line and what is wrong.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A CSV file with a header line; empty lines and lines that start with # are left out.
class Csv {
 public:
  // Throws InputError, also when one of `required` is no column.
  Csv(std::filesystem::path file, const std::vector<std::string>& required);

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] bool has(const std::string& column) const { return columns_.count(column) != 0; }
  // Throw InputError with the line when the cell is not what is asked for.
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  // NaN where the cell is empty or the column is not there.
  [[nodiscard]] double number_or_nan(std::size_t row, const std::string& column) const;
  // A whole number that is not negative.
  [[nodiscard]] int index(std::size_t row, const std::string& column) const;
  [[noreturn]] void fail(std::size_t row, const std::string& what) const;

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> cells;
  };

  std::filesystem::path file_;
  std::map<std::string, std::size_t> columns_;
  std::vector<Row> rows_;
};

struct NumberRow {
  std::size_t line;
  std::vector<double> numbers;
};

// Rows of numbers between blanks or commas; # starts a comment. Throws InputError.
[[nodiscard]] std::vector<NumberRow> read_numbers(const std::filesystem::path& file);

[[noreturn]] void fail_at(const std::filesystem::path& file, std::size_t line,
                          const std::string& what);

}  // namespace egomod::eval
