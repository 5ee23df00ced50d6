// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "options.hpp"

namespace egomod::fit {

// The thesis's Rayleigh laws and the speed at which they are as probable: prints and draws them.
// Throws an exception that says why there is no such model, and the remedy.
[[nodiscard]] FitResult fit_thesis(const Options& options);

}  // namespace egomod::fit
