// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "world.hpp"

namespace egomod::sim {

struct WorldError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws WorldError: "file:line: key: what is wrong".
[[nodiscard]] World read_world(const std::filesystem::path& file);
// A path, if it has a slash or ends in .toml; else a world in `folder`.
[[nodiscard]] std::filesystem::path find_world(const std::string& name,
                                               const std::filesystem::path& folder);
[[nodiscard]] std::vector<std::string> worlds_in(const std::filesystem::path& folder);
// Beside the program, in the build tree as where it is installed.
[[nodiscard]] std::filesystem::path world_folder();

}  // namespace egomod::sim
