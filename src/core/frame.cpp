// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/frame.hpp"

namespace egomod {

const char* name(Stage stage) {
  static constexpr std::array<const char*, kStageCount> kNames{"capture", "features", "egomotion",
                                                               "moving_objects", "publish"};
  return kNames[static_cast<std::size_t>(stage)];
}

}  // namespace egomod
