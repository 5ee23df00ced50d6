// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace egomod::demo {

// A small CSV file with a header line. Errors throw std::runtime_error naming file and line.
class Csv {
 public:
  explicit Csv(const std::filesystem::path& file);

  [[nodiscard]] std::size_t rows() const { return cells_.size(); }
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;

 private:
  std::filesystem::path file_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::vector<std::string>> cells_;
};

// Rows of whitespace-separated numbers, `count` in each.
[[nodiscard]] std::vector<std::vector<double>> read_numbers(const std::filesystem::path& file,
                                                            std::size_t count);

}  // namespace egomod::demo
