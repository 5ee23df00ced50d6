// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include "egomod/app/config.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

// Beside the program, in the build tree as where it is installed.
fs::path preset_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "share" / "egomod" / "presets";
}

std::string presets_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".toml") {
      names.push_back(entry.path().stem());
    }
  }
  std::ranges::sort(names);
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text.empty() ? "none" : text;
}

}  // namespace

std::string find_preset(const std::string& name) {
  if (name.find('/') != std::string::npos || name.ends_with(".toml")) {
    return name;
  }
  const fs::path folder = preset_folder();
  const fs::path file = folder / (name + ".toml");
  if (!fs::exists(file)) {
    throw ConfigError("--preset " + name + ": no such preset in " + folder.string() +
                      "; there are: " + presets_in(folder) + "; or give the path of a file");
  }
  return file;
}

}  // namespace egomod
