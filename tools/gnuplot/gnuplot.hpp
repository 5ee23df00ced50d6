// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace egomod::gnuplot {

// gnuplot is not there, or did not draw: says which, and the remedy.
class GnuplotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Runs gnuplot on a script, in the folder that holds it. Throws GnuplotError.
void run(const std::string& folder, const std::string& script);

}  // namespace egomod::gnuplot
