// SPDX-License-Identifier: Apache-2.0
#include "table_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace egomod::sim {
namespace {

// "object[2].kind" without the number.
std::string without_numbers(const std::string& key) {
  std::string out;
  bool inside = false;
  for (const char c : key) {
    inside = inside || c == '[';
    if (!inside) out += c;
    inside = inside && c != ']';
  }
  return out;
}

std::string range_of(double min, double max) { return fmt::format("{} to {}", min, max); }

template <typename Value>
std::string text_of(const std::optional<Value>& fallback) {
  return fallback ? fmt::format("{}", *fallback) : "";
}

constexpr const char* kTable = "table";

}  // namespace

std::string TableReader::joined(const std::string& key) const {
  return name_.empty() ? key : name_ + "." + key;
}

void TableReader::fail(const std::string& key, const std::string& why) const {
  const toml::node* node = table_.get(key);
  const auto line = (node != nullptr ? node->source() : table_.source()).begin.line;
  throw WorldError(
      fmt::format("{}:{}: {}: {}", file_, std::max<std::size_t>(1, line), joined(key), why));
}

const toml::node* TableReader::find(const std::string& key, const KeyDescription& description) {
  known_.insert(key);
  if (catalogue_ != nullptr) catalogue_->emplace(without_numbers(joined(key)), description);
  const toml::node* node = table_.get(key);
  const bool required = description.fallback.empty() && description.range != kTable;
  if (node == nullptr && required) fail(key, "is missing");
  return node;
}

double TableReader::checked(const toml::node& node, const std::string& key, double min,
                            double max) const {
  if (!node.is_number()) fail(key, "a number is needed");
  const double value = *node.value<double>();
  if (!std::isfinite(value)) fail(key, "must be finite");
  if (value < min || value > max) {
    fail(key, fmt::format("{} is outside {} to {}", value, min, max));
  }
  return value;
}

double TableReader::number(const std::string& key, std::optional<double> fallback, double min,
                           double max) {
  const toml::node* node = find(key, {text_of(fallback), range_of(min, max)});
  return node == nullptr ? *fallback : checked(*node, key, min, max);
}

int TableReader::integer(const std::string& key, std::optional<int> fallback, int min, int max) {
  const toml::node* node = find(key, {text_of(fallback), range_of(min, max)});
  if (node == nullptr) return *fallback;
  if (!node->is_integer()) fail(key, "a whole number is needed");
  return static_cast<int>(checked(*node, key, min, max));
}

std::vector<double> TableReader::row(const toml::node& node, const std::string& key,
                                     std::size_t count, double min, double max) const {
  const toml::array* array = node.as_array();
  if (array == nullptr || array->size() != count) {
    fail(key, fmt::format("a list of {} numbers is needed", count));
  }
  std::vector<double> values;
  for (const toml::node& value : *array) values.push_back(checked(value, key, min, max));
  return values;
}

std::vector<double> TableReader::numbers(const std::string& key, std::size_t count, double min,
                                         double max, const std::vector<double>& fallback) {
  const toml::node* node =
      find(key, {fallback.empty() ? "" : fmt::format("{}", fallback), range_of(min, max)});
  return node == nullptr ? fallback : row(*node, key, count, min, max);
}

std::vector<std::vector<double>> TableReader::points(const std::string& key, double min,
                                                     double max) {
  const toml::array* array = find(key, {"", range_of(min, max)})->as_array();
  if (array == nullptr || array->size() < 2) fail(key, "a list of at least two [x, z] is needed");
  std::vector<std::vector<double>> rows;
  for (const toml::node& node : *array) rows.push_back(row(node, key, 2, min, max));
  return rows;
}

std::size_t TableReader::choice(const std::string& key, const std::vector<std::string>& names,
                                std::optional<std::size_t> fallback) {
  const std::string range = fmt::format("{}", fmt::join(names, ", "));
  const toml::node* node = find(key, {fallback ? names[*fallback] : "", range});
  if (node == nullptr) return *fallback;
  const auto value = node->value<std::string>();
  for (std::size_t i = 0; value && i < names.size(); ++i) {
    if (*value == names[i]) return i;
  }
  fail(key, "must be one of " + range);
}

void TableReader::table(const std::string& key, const std::function<void(TableReader&)>& read) {
  const toml::node* node = find(key, {"", kTable});
  if (node == nullptr) return;
  if (!node->is_table()) fail(key, "a table is needed");
  TableReader reader(*node->as_table(), file_, joined(key), catalogue_);
  read(reader);
  reader.finish();
}

void TableReader::tables(const std::string& key, const std::function<void(TableReader&)>& read) {
  const toml::node* node = find(key, {"", kTable});
  if (node == nullptr) return;
  if (!node->is_array_of_tables()) fail(key, fmt::format("write it as [[{}]]", joined(key)));
  std::size_t number = 0;
  for (const toml::node& element : *node->as_array()) {
    TableReader reader(*element.as_table(), file_, fmt::format("{}[{}]", joined(key), ++number),
                       catalogue_);
    read(reader);
    reader.finish();
  }
}

void TableReader::finish() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(std::string(key.str()))) continue;
    fail(std::string(key.str()),
         fmt::format("there is no such key; there are: {}", fmt::join(known_, ", ")));
  }
}

}  // namespace egomod::sim
