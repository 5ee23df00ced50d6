// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace egomod::sim {

// A contact sheet of all worlds of a folder: what the left camera sees of each in the middle of its
// time, with the world's name. PNG; overwritten. Throws std::runtime_error.
void write_gallery(const std::filesystem::path& worlds, const std::filesystem::path& file);

}  // namespace egomod::sim
