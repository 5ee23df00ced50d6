// SPDX-License-Identifier: Apache-2.0
#include "labels.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "result_file.hpp"

namespace egomod::fit {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.emplace_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

}  // namespace

Table::Table(const std::string& path) : path_(path) {
  std::ifstream file(path);
  if (!file) throw InputError(path + ": cannot be opened");
  std::string text;
  for (int line = 1; std::getline(file, text); ++line) {
    const std::string_view content = trimmed(text);
    if (content.empty() || content.front() == '#') continue;
    if (header_.empty()) {
      header_ = cells_of(content);
      header_line_ = line;
      continue;
    }
    rows_.push_back({line, cells_of(content)});
    if (rows_.back().cells.size() != header_.size()) {
      fail(line, "has " + std::to_string(rows_.back().cells.size()) + " cells, the header has " +
                     std::to_string(header_.size()));
    }
  }
  if (file.bad()) throw InputError(path + ": cannot be read");
  if (header_.empty()) throw InputError(path + ": is empty, a header line is expected");
}

void Table::fail(int line, const std::string& message) const {
  throw InputError(path_ + ":" + std::to_string(line) + ": " + message);
}

std::size_t Table::column(const std::string& name) const {
  const auto at = std::find(header_.begin(), header_.end(), name);
  if (at == header_.end()) fail(header_line_, "the header lacks the column '" + name + "'");
  return static_cast<std::size_t>(at - header_.begin());
}

double Table::number(const Row& row, std::size_t column) const {
  const std::string& cell = row.cells[column];
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    fail(row.line, header_[column] + " '" + cell + "' is not a finite number");
  }
  return value;
}

bool Table::flag(const Row& row, std::size_t column) const {
  const double value = number(row, column);
  if (value != 0.0 && value != 1.0) {
    fail(row.line, header_[column] + " '" + row.cells[column] + "' is neither 0 nor 1");
  }
  return value != 0.0;
}

Labels read_labels(const std::string& path) {
  const Table table(path);
  const std::size_t speed = table.column("speed_mps");
  const std::size_t moving = table.column("moving");
  Labels labels;
  for (const Table::Row& row : table.rows()) {
    const double speed_mps = table.number(row, speed);
    if (speed_mps < 0.0) {
      throw InputError(path + ":" + std::to_string(row.line) + ": speed_mps '" + row.cells[speed] +
                       "' is negative");
    }
    (table.flag(row, moving) ? labels.moving_mps : labels.static_mps).push_back(speed_mps);
  }
  return labels;
}

void write_labels(const std::string& path, const Labels& labels) {
  log::ResultFile result(path);
  std::ofstream file(result.path());
  file << "speed_mps,moving\n";
  for (const double speed_mps : labels.static_mps) file << speed_mps << ",0\n";
  for (const double speed_mps : labels.moving_mps) file << speed_mps << ",1\n";
  if (!file.flush()) throw InputError(path + ": cannot be written");
  result.keep();
}

}  // namespace egomod::fit
