// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace egomod::fit {

struct Options {
  std::string method = "thesis";
  std::string labels;
  std::vector<std::string> records, truths;
  std::string points = "all";
  std::string preset;
  std::string output = ".";
  std::string format = "png";
  std::optional<double> prior_moving;
  double max_speed_mps = 0.0;
  bool plot = true;
};

// A key of [moving_objects] with what fits the samples.
struct FittedKey {
  std::string name;
  double value = 0.0;
};

struct FitResult {
  std::vector<FittedKey> keys;
  std::string damage;  // of the records; empty if they are whole
};

}  // namespace egomod::fit
