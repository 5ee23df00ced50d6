// SPDX-License-Identifier: Apache-2.0
#include "tables.hpp"

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

namespace egomod::eval {
namespace {

constexpr double kMaxIndex = 1e9;

std::ifstream open(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw InputError(file.string() +
                     ": cannot be read: " + (stream ? "it is a folder" : std::strerror(errno)));
  }
  return stream;
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(trimmed(cell));
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

std::optional<double> parsed(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

void fail_at(const std::filesystem::path& file, std::size_t line, const std::string& what) {
  throw InputError(file.string() + ":" + std::to_string(line) + ": " + what);
}

Csv::Csv(std::filesystem::path file, const std::vector<std::string>& required)
    : file_(std::move(file)) {
  std::ifstream stream = open(file_);
  std::size_t line_number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++line_number;
    const std::string content = trimmed(line);
    if (content.empty() || content.front() == '#') continue;
    std::vector<std::string> cells = cells_of(content);
    if (columns_.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) columns_[cells[i]] = i;
      for (const std::string& column : required) {
        if (!has(column)) fail_at(file_, line_number, "the header has no column '" + column + "'");
      }
      continue;
    }
    if (cells.size() < columns_.size()) {
      fail_at(file_, line_number,
              std::to_string(cells.size()) + " cells where the header names " +
                  std::to_string(columns_.size()));
    }
    rows_.push_back({line_number, std::move(cells)});
  }
  if (columns_.empty()) throw InputError(file_.string() + ": is empty; a header line is expected");
}

void Csv::fail(std::size_t row, const std::string& what) const {
  fail_at(file_, rows_[row].line, what);
}

const std::string& Csv::text(std::size_t row, const std::string& column) const {
  return rows_[row].cells[columns_.at(column)];
}

double Csv::number(std::size_t row, const std::string& column) const {
  const auto value = parsed(text(row, column));
  if (!value || !std::isfinite(*value)) {
    fail(row, "column '" + column + "': '" + text(row, column) + "' is not a finite number");
  }
  return *value;
}

double Csv::number_or_nan(std::size_t row, const std::string& column) const {
  if (!has(column) || text(row, column).empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto value = parsed(text(row, column));
  if (!value) fail(row, "column '" + column + "': '" + text(row, column) + "' is not a number");
  return *value;
}

int Csv::index(std::size_t row, const std::string& column) const {
  const double value = number(row, column);
  if (value < 0.0 || value > kMaxIndex || value != std::floor(value)) {
    fail(row, "column '" + column + "': '" + text(row, column) + "' is not a whole number from 0");
  }
  return static_cast<int>(value);
}

std::vector<NumberRow> read_numbers(const std::filesystem::path& file) {
  std::ifstream stream = open(file);
  std::vector<NumberRow> rows;
  std::size_t line_number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++line_number;
    line.resize(std::min(line.find('#'), line.size()));
    for (char& c : line) c = c == ',' ? ' ' : c;
    NumberRow row{line_number, {}};
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      const auto value = parsed(word);
      if (!value) fail_at(file, line_number, "'" + word + "' is not a number");
      row.numbers.push_back(*value);
    }
    if (!row.numbers.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace egomod::eval
