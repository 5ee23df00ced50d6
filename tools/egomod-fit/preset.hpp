// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "options.hpp"

namespace egomod::fit {

// The text of a TOML file with these keys in its table [moving_objects], in place where they are
// there; all else stays as it is, to the letter. Appends a line to `changes` for each of them.
// Throws InputError, with the line, where the table or its keys are spelt in another way.
[[nodiscard]] std::string with_keys(const std::string& text, const std::vector<FittedKey>& keys,
                                    std::string& changes);

// Writes the preset, or a new file of these keys alone, to the folder `options.output`. Prints how
// it differs. Throws InputError.
void write_preset(const Options& options, const std::vector<FittedKey>& keys);

}  // namespace egomod::fit
