// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "folder_writer.hpp"

namespace egomod::sim {

struct Recording {
  std::string folder;  // empty: none
  std::string log;     // empty: none
  FolderOptions options;
};

struct RecordingSummary {
  int left_images = 0;
  int right_images = 0;
  double took_s = 0.0;
};

// Renders all that the world's cameras deliver, in order of exposure. Throws std::runtime_error.
RecordingSummary record(Simulator& simulator, const Recording& recording);

}  // namespace egomod::sim
