// SPDX-License-Identifier: Apache-2.0
// docs/worlds.md lists every key that a world file may have, with its default and its range.
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "materials.hpp"
#include "world_file.hpp"

namespace egomod::sim {
namespace {

namespace fs = std::filesystem;

// Between them these ask for every key: each kind of shell, object and motion is there.
KeyCatalogue all_keys() {
  KeyCatalogue keys;
  for (const std::string& name : worlds_in(EGOMOD_WORLDS_DIR)) {
    (void)read_world(find_world(name, EGOMOD_WORLDS_DIR), &keys);
  }
  return keys;
}

// Tables that are alike are documented once.
std::string canonical(const std::string& key) {
  for (const std::string prefix : {"rig.motion.", "object.motion."}) {
    if (key.starts_with(prefix)) return "motion." + key.substr(prefix.size());
  }
  const std::string right = "camera.right.";
  return key.starts_with(right) ? "camera.left." + key.substr(right.size()) : key;
}

std::string range_of(const KeyDescription& description) {
  return description.range == fmt::format("{}", fmt::join(material_names(), ", "))
             ? "a material"
             : description.range;
}

struct DocumentedKey {
  std::string fallback;
  std::string range;
};

std::string trimmed(std::string text) {
  text.erase(0, text.find_first_not_of(" `"));
  text.erase(text.find_last_not_of(" `") + 1);
  return text;
}

// Rows of tables whose first column holds a key: | `key` | unit | default | range | ... |
std::map<std::string, DocumentedKey> documented_keys() {
  std::map<std::string, DocumentedKey> keys;
  std::ifstream file(EGOMOD_DOCS_DIR "/worlds.md");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(trimmed(cell));
    if (cells.size() >= 5) keys[cells[0]] = {cells[2], cells[3]};
  }
  return keys;
}

// More may be said after it in parentheses.
bool says(const std::string& cell, const std::string& what) {
  return cell == what || cell.starts_with(what + " (");
}

TEST(Documentation, ListsEveryKeyOfWorldFiles) {
  const KeyCatalogue keys = all_keys();
  const auto documented = documented_keys();
  EXPECT_GT(keys.size(), 100U);
  for (const auto& [key, is] : keys) {
    if (is.range == "table") continue;
    const auto said = documented.find(canonical(key));
    if (said == documented.end()) {
      ADD_FAILURE() << "docs/worlds.md lacks | `" << canonical(key) << "` | unit | " << is.fallback
                    << " | " << range_of(is) << " | meaning |";
      continue;
    }
    const std::string fallback = is.fallback.empty() ? "required" : is.fallback;
    EXPECT_TRUE(says(said->second.fallback, fallback)) << key << ": " << fallback;
    EXPECT_TRUE(says(said->second.range, range_of(is))) << key << ": " << range_of(is);
  }
}

TEST(Documentation, ListsNoKeyThatIsNone) {
  std::set<std::string> keys;
  for (const auto& [key, is] : all_keys()) keys.insert(canonical(key));
  for (const auto& [key, said] : documented_keys()) EXPECT_TRUE(keys.contains(key)) << key;
}

TEST(Documentation, NamesEveryWorldAndMaterial) {
  std::ostringstream text;
  text << std::ifstream(EGOMOD_DOCS_DIR "/worlds.md").rdbuf();
  for (const auto& names : {worlds_in(EGOMOD_WORLDS_DIR), material_names()}) {
    for (const std::string& name : names) {
      EXPECT_THAT(text.str(), testing::HasSubstr("| " + name + " |"));
    }
  }
}

}  // namespace
}  // namespace egomod::sim
