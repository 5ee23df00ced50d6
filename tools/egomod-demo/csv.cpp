// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace egomod::demo {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

std::ifstream opened(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(fmt::format("cannot read {}", file.string()));
  return in;
}

}  // namespace

Csv::Csv(const std::filesystem::path& file) : file_(file) {
  auto in = opened(file);
  std::string line;
  std::getline(in, line);
  const auto names = split(line);
  for (std::size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
  while (std::getline(in, line)) {
    cells_.push_back(split(line));
    if (cells_.back().size() != names.size()) {
      throw std::runtime_error(fmt::format("{}:{}: {} cells, the header has {}", file.string(),
                                           rows() + 1, cells_.back().size(), names.size()));
    }
  }
}

const std::string& Csv::text(std::size_t row, const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) {
    throw std::runtime_error(fmt::format("{}:1: no column '{}'", file_.string(), column));
  }
  return cells_.at(row)[found->second];
}

double Csv::number(std::size_t row, const std::string& column) const {
  const std::string& cell = text(row, column);
  try {
    return std::stod(cell);
  } catch (const std::logic_error&) {
    throw std::runtime_error(
        fmt::format("{}:{}: '{}' is no number", file_.string(), row + 2, cell));
  }
}

std::vector<std::vector<double>> read_numbers(const std::filesystem::path& file,
                                              std::size_t count) {
  auto in = opened(file);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (double value; cells >> value;) rows.back().push_back(value);
    if (rows.back().size() != count) {
      throw std::runtime_error(
          fmt::format("{}:{}: want {} numbers", file.string(), rows.size(), count));
    }
  }
  return rows;
}

}  // namespace egomod::demo
