// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/core/image.hpp"

namespace egomod {

// Standard deviation of the noise of an image, in grey levels.
[[nodiscard]] float estimate_noise_sigma(const ImageView& image);

}  // namespace egomod
