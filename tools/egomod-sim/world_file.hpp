// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "table_reader.hpp"
#include "world.hpp"

namespace egomod::sim {

// Throws WorldError: "file:line: key: what is wrong". `catalogue` gets the keys that such a file
// may have.
[[nodiscard]] World read_world(const std::filesystem::path& file,
                               KeyCatalogue* catalogue = nullptr);
// A path, if it has a slash or ends in .toml; else a world in `folder`.
[[nodiscard]] std::filesystem::path find_world(const std::string& name,
                                               const std::filesystem::path& folder);
[[nodiscard]] std::vector<std::string> worlds_in(const std::filesystem::path& folder);
// Beside the program, in the build tree as where it is installed.
[[nodiscard]] std::filesystem::path world_folder();

}  // namespace egomod::sim
