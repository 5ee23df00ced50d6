// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "findings.hpp"
#include "pictures.hpp"

namespace egomod::thesis {

// All that both pages show.
struct Reproduction {
  Cases cases;
  std::vector<ThresholdFit> fits;
  Pictures pictures;
};

// One page that needs no other file.
[[nodiscard]] std::string html_of(const Reproduction& reproduction);
// `pictures`: where the files of the pictures are, as seen from the summary.
[[nodiscard]] std::string markdown_of(const Reproduction& reproduction,
                                      const std::filesystem::path& pictures);

}  // namespace egomod::thesis
