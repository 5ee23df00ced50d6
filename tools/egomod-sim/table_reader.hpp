// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace egomod::sim {

struct WorldError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What a key of a world file may be.
struct KeyDescription {
  std::string fallback;  // empty: the key is required, or is a table
  std::string range;
};
// By the key's full name: "object.motion.speed_mps".
using KeyCatalogue = std::map<std::string, KeyDescription>;

// Reads one table of a file, and complains with file, line and key about whatever cannot be used;
// `finish` complains about keys that nobody asked for. Throws WorldError.
class TableReader {
 public:
  // Into `catalogue`, where there is one, goes every key that is asked for; the first reader of a
  // key describes it.
  TableReader(const toml::table& table, std::string file, std::string name,
              KeyCatalogue* catalogue = nullptr)
      : table_(table), file_(std::move(file)), name_(std::move(name)), catalogue_(catalogue) {}

  [[nodiscard]] bool has(const std::string& key) const { return table_.contains(key); }
  // Inclusive limits.
  double number(const std::string& key, std::optional<double> fallback, double min, double max);
  int integer(const std::string& key, std::optional<int> fallback, int min, int max);
  std::vector<double> numbers(const std::string& key, std::size_t count, double min, double max,
                              const std::vector<double>& fallback = {});
  std::vector<std::vector<double>> points(const std::string& key, double min, double max);
  // One of `names`; which one.
  std::size_t choice(const std::string& key, const std::vector<std::string>& names,
                     std::optional<std::size_t> fallback);
  // Nothing is called where the key is missing.
  void table(const std::string& key, const std::function<void(TableReader&)>& read);
  void tables(const std::string& key, const std::function<void(TableReader&)>& read);
  void finish() const;
  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  const toml::node* find(const std::string& key, const KeyDescription& description);
  [[nodiscard]] double checked(const toml::node& node, const std::string& key, double min,
                               double max) const;
  [[nodiscard]] std::vector<double> row(const toml::node& node, const std::string& key,
                                        std::size_t count, double min, double max) const;
  [[nodiscard]] std::string joined(const std::string& key) const;

  const toml::table& table_;
  std::string file_;
  std::string name_;
  KeyCatalogue* catalogue_;
  std::set<std::string> known_;
};

}  // namespace egomod::sim
