// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace egomod::fit {

// Input that cannot be used; the text names file, line and remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Speeds of points known to be static and known to move, m/s.
struct Labels {
  std::vector<double> static_mps;
  std::vector<double> moving_mps;
};

// A CSV file with the columns `speed_mps` and `moving` (0 or 1), in any place among others.
[[nodiscard]] Labels read_labels(const std::string& path);
void write_labels(const std::string& path, const Labels& labels);

// One CSV file as rows of cells, spaces trimmed, '#' lines and empty ones left out.
class Table {
 public:
  explicit Table(const std::string& path);

  struct Row {
    int line = 0;
    std::vector<std::string> cells;
  };
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  // Index of a column; throws InputError when the header lacks it.
  [[nodiscard]] std::size_t column(const std::string& name) const;
  // A finite number; throws InputError with file and line.
  [[nodiscard]] double number(const Row& row, std::size_t column) const;
  [[nodiscard]] bool flag(const Row& row, std::size_t column) const;

 private:
  [[noreturn]] void fail(int line, const std::string& message) const;

  std::string path_;
  std::vector<std::string> header_;
  int header_line_ = 1;
  std::vector<Row> rows_;
};

}  // namespace egomod::fit
